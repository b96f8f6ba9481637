/** Motion that is not stored: the server makes it for an eye's worth, as positions at even steps. */
import { itemAt, numberAt } from "../../lists";
import type { Schemas } from "../../api/client";
import { bonesOf, type Skeleton } from "../body/skeleton";
import { fromBase64 } from "./thumbnail";

const MOST_BYTES = 4 << 20;
const USUAL_HEIGHT = 1.7;

/** Positions at every `step`-th frame, (n, points, 3); between them straight lines are drawn. */
export class Preview {
  constructor(
    readonly skeleton: Skeleton,
    readonly frames: number,
    readonly perSecond: number,
    private readonly values: Float32Array,
    private readonly step: number,
  ) {}

  frame(index: number): Float32Array {
    const stride = this.skeleton.points * 3;
    const rows = this.values.length / stride;
    const exact = Math.max(0, Math.min(rows - 1, index / this.step));
    const row = Math.floor(exact);
    const share = exact - row;
    if (!share || row + 1 >= rows) return this.values.subarray(row * stride, (row + 1) * stride);
    const found = new Float32Array(stride);
    for (let at = 0; at < stride; at++)
      found[at] =
        numberAt(this.values, row * stride + at) * (1 - share) + numberAt(this.values, (row + 1) * stride + at) * share;
    return found;
  }
}

export type Told = Schemas["PreviewMotion"];
type Head = Omit<Told, "data">;

const MOST_FRAMES = 4000; // of one answer

/** How many frames apart a preview of so many is told. */
export const stepFor = (frames: number, points: number): number =>
  Math.max(1, Math.ceil((frames * points * 12) / MOST_BYTES), Math.ceil(frames / MOST_FRAMES));

/** What the server told of a motion, to be played on a body. */
export function previewOf(told: Told, skeleton: Skeleton, frames: number, perSecond: number, step: number): Preview {
  return new Preview(skeleton, frames, perSecond, numbersOf(told), step);
}

/** The positions that an answer in JSON carries. */
export function numbersOf(told: Told): Float32Array {
  const bytes = fromBase64(told.data);
  return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
}

/** A motion that is told as a whole, on a body of what is told of it. */
export function wholeOf(head: Head, positions: Float32Array): Preview {
  return new Preview(
    bodyOf(head, positions, numberAt(head.shape, 0)),
    numberAt(head.shape, 0),
    1 / (head.seconds_per_frame || 1 / 30),
    positions,
    1,
  );
}

/** A body of nothing but what a preview says: joints, their parents, and the first pose's size. */
export function bodyOf(told: Head, values: Float32Array, frames: number): Skeleton {
  const joints = told.bones.length;
  const side = (name: string) => (/left|^l[_A-Z]/.test(name) ? 1 : /right|^r[_A-Z]/.test(name) ? 2 : 0);
  const sides = new Uint8Array(told.parents.length);
  told.parents.forEach((parent, point) => {
    // Fingers and twist joints, whose own names tell no side, are on that of the joint above.
    sides[point] = (point < joints && side(itemAt(told.bones, point))) || (parent < 0 ? 0 : numberAt(sides, parent));
  });
  let [least, most] = [Infinity, -Infinity];
  const axis = told.up.endsWith("Z") ? 2 : 1;
  for (let at = axis; at < told.parents.length * 3; at += 3) {
    if (numberAt(values, at) < least) least = numberAt(values, at);
    if (numberAt(values, at) > most) most = numberAt(values, at);
  }
  const extent = most - least;
  const metres = told.metres ?? (extent > 0 ? USUAL_HEIGHT / extent : 1);
  return {
    view: {
      id: "",
      name: "",
      revision: 0,
      frames,
      markers: told.parents.every((one) => one < 0),
      likely_up: told.up,
      origin: told.origin,
      bones: told.bones.map((name) => ({ name })),
      tips: [],
      plates: [],
    } as unknown as Skeleton["view"],
    points: told.parents.length,
    edges: Int32Array.from(bonesOf(told.parents, told.bones).flat()),
    sides,
    parents: Int32Array.from(told.parents),
    metres,
    unitKnown: Boolean(told.metres),
    zUp: axis === 2,
    height: extent > 0 ? extent * metres : USUAL_HEIGHT,
    head: told.bones.findIndex((name) => name.toLowerCase() === "head"),
    byName: new Map(told.bones.map((name, index) => [name, index])),
  };
}
