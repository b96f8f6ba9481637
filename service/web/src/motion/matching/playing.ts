/** What a walker plays, as points to be drawn, and as segments that a composition takes. */
import type { Schemas } from "../../api/client";
import { entryOf, itemAt, numberAt } from "../../lists";
import { turn, type Facts, type Library } from "./library";
import type { Run } from "./walker";

/** Positions of a clip's points: every step-th frame, in the clip's unit, `stride` numbers each. */
export interface Sampled {
  values: Float32Array;
  stride: number;
  step: number;
}

const AXES: Record<string, number> = { X: 0, Y: 1, Z: 2 };

/** Indices of the level axes of places, and of the one that points up. */
function axesOf(facts: Facts): [number, number, number] {
  const [first, second] = [entryOf(AXES, facts.axes.charAt(0)), entryOf(AXES, facts.axes.charAt(1))];
  return [first, second, 3 - first - second];
}

/** The points at a row, which may lie between two, of a run that is placed on the ground. */
export function posed(library: Library, clips: readonly Sampled[], run: Run, row: number): Float32Array {
  const { facts } = library;
  const number = library.clipOf(Math.floor(row));
  const [clip, { values, stride, step }] = [itemAt(facts.clips, number), itemAt(clips, number)];
  const last = values.length / stride - 1;
  const at = Math.max(
    0,
    Math.min(last, (clip.skipped + (row - clip.first) / facts.rate / clip.seconds_per_frame) / step),
  );
  const [low, part] = [Math.floor(at) * stride, at % 1];
  const high = Math.min(low + stride, last * stride);
  const made = new Float32Array(stride);
  const [first, second, up] = axesOf(facts);
  const [cosine, sine] = [Math.cos(run.angle), Math.sin(run.angle)];
  for (let point = 0; point < stride; point += 3) {
    const of = (axis: number) =>
      (1 - part) * numberAt(values, low + point + axis) + part * numberAt(values, high + point + axis);
    const [x, y] = [of(first), of(second)];
    made[point + first] = cosine * x - sine * y + run.shift[0] / clip.metres;
    made[point + second] = sine * x + cosine * y + run.shift[1] / clip.metres;
    made[point + up] = of(up);
  }
  return made;
}

/**
 * A difference that decays from a cut on, with its speed (Bollo, "Inertialization", GDC 2018), as the server's `decay`.
 * at, length: frames since the cut, and until nothing of it is left. speed: a frame.
 */
export function decay(value: number, speed: number, at: number, length: number): number {
  const sign = value < 0 ? -1 : 1;
  const x0 = Math.abs(value);
  const v0 = Math.min(speed * sign, 0);
  let t1 = v0 < 0 ? Math.min(length, (-5 * x0) / v0) : length;
  if (!(t1 > 0)) t1 = 1;
  if (at >= t1 || !(x0 > 0)) return 0;
  const a0 = Math.max(0, (-8 * v0 * t1 - 20 * x0) / t1 ** 2);
  const five = -(a0 * t1 ** 2 + 6 * v0 * t1 + 12 * x0) / (2 * t1 ** 5);
  const four = (3 * a0 * t1 ** 2 + 16 * v0 * t1 + 30 * x0) / (2 * t1 ** 4);
  const three = -(3 * a0 * t1 ** 2 + 12 * v0 * t1 + 20 * x0) / (2 * t1 ** 3);
  return sign * (((((five * at + four) * at + three) * at + a0 / 2) * at + v0) * at + x0);
}

/** The segments of runs, each with its place, for `POST /compose`. */
export function segmentsOf(library: Library, runs: readonly Run[]) {
  const { facts } = library;
  const [first, second] = axesOf(facts);
  const sign = facts.up.startsWith("-") ? -1 : 1;
  return runs.flatMap((run) => {
    const clip = itemAt(facts.clips, library.clipOf(Math.max(0, run.last)));
    const frame = (row: number) => clip.skipped + Math.round((row - clip.first) / facts.rate / clip.seconds_per_frame);
    const [from, to] = [frame(run.first), Math.min(frame(run.last + 1), clip.frames) - 1];
    if (to < from || run.last < run.first) return [];
    const shift: [number, number, number] = [0, 0, 0];
    shift[first] = run.shift[0] / clip.metres;
    shift[second] = run.shift[1] / clip.metres;
    const degrees = (run.angle * 180 * sign) / Math.PI;
    const place = { degrees: ((((degrees + 180) % 360) + 360) % 360) - 180, shift };
    return [{ document: clip.document, revision: clip.revision, first: from + 1, last: to + 1, place }];
  }) as Partial<Schemas["Segment"]>[] as Schemas["Segment"][];
}

/** A velocity on the ground, metres a second, of the row that a run plays. */
export function velocityOf(library: Library, run: Run, row: number): readonly [number, number] {
  const clip = itemAt(library.facts.clips, library.clipOf(row));
  const [before, after] = [Math.max(clip.first, row - 1), Math.min(clip.last, row + 1)];
  if (after <= before) return [0, 0];
  const [one, two] = [library.place(before), library.place(after)];
  const by = library.facts.rate / (after - before);
  return turn([(two[0] - one[0]) * by, (two[1] - one[1]) * by], run.angle);
}
