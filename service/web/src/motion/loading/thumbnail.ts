/** MT1: moving skeletons in a few KB (mcml/motion/thumbnails.py has the format). Reading, and drawing on a canvas. */
import { numberAt } from "../../lists";

export interface Thumbnail {
  markers: boolean;
  face: boolean;
  points: number;
  bones: { a: number; b: number; side: number; depth: number }[];
  seconds: number;
  aspect: number;
  groundStep: number;
  loop: Uint8Array; // (poses, points, 2)
  loopPoses: number;
  scrub: Uint8Array;
  scrubPoses: number;
  loopGround: Uint8Array;
  scrubGround: Uint8Array;
  /** The pose of the loop farthest from its mean. */
  poster: number;
  /** The point that is highest on average: the head. */
  head: number;
}

const FACE = 1;
const MARKERS = 2;

/** Error for what is no thumbnail. */
export function readThumbnail(bytes: Uint8Array): Thumbnail {
  if (bytes.length < 20 || String.fromCharCode(...bytes.subarray(0, 3)) !== "MT1") throw new Error("no thumbnail");
  const [flags = 0, points = 0, bones = 0, loopPoses = 0, scrubPoses = 0] = bytes.subarray(3, 8);
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  let at = 20;
  const take = (size: number) => bytes.subarray(at, (at += size));
  const limbs = take(bones * 3);
  const loop = take(loopPoses * points * 2);
  const scrub = take(scrubPoses * points * 2);
  const ground = take(loopPoses + scrubPoses);
  if (at > bytes.length) throw new Error("a thumbnail that ends early");
  const found = {
    markers: Boolean(flags & MARKERS),
    face: Boolean(flags & FACE),
    points,
    bones: Array.from({ length: bones }, (_, index) => {
      const [a = 0, b = 0, kind = 0] = limbs.subarray(index * 3, index * 3 + 3);
      return { a, b, side: kind & 3, depth: kind >> 2 };
    }),
    seconds: view.getFloat32(8, true),
    aspect: view.getFloat32(12, true),
    groundStep: view.getFloat32(16, true),
    loop,
    loopPoses,
    scrub,
    scrubPoses,
    loopGround: ground.subarray(0, loopPoses),
    scrubGround: ground.subarray(loopPoses),
  };
  return { ...found, poster: posterOf(loop, loopPoses, points), head: headOf(found.bones, loop, loopPoses, points) };
}

export const fromBase64 = (text: string): Uint8Array => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));

function posterOf(loop: Uint8Array, poses: number, points: number): number {
  const size = points * 2;
  const means = new Float64Array(size);
  for (let at = 0; at < loop.length; at++) means[at % size] = numberAt(means, at % size) + numberAt(loop, at) / poses;
  let best = 0;
  let most = -1;
  for (let pose = 0; pose < poses; pose++) {
    let away = 0;
    for (let at = 0; at < size; at++) away += (numberAt(loop, pose * size + at) - numberAt(means, at)) ** 2;
    if (away > most) [most, best] = [away, pose];
  }
  return best;
}

function headOf(bones: { b: number }[], loop: Uint8Array, poses: number, points: number): number {
  let best = -1;
  let least = Infinity;
  for (const { b } of bones) {
    let sum = 0;
    for (let pose = 0; pose < poses; pose++) sum += numberAt(loop, (pose * points + b) * 2 + 1);
    if (sum < least) [least, best] = [sum, b];
  }
  return best;
}

export interface Inks {
  sides: [string, string, string];
  line: string;
}

const MARGIN = 0.1; // of the height, above the head
const FLOOR = 0.12; // of the height, below the feet
const LIMB = 2.5;

/**
 * Draw a moment. phase: 0 to 1 of the loop, or of the whole clip with `whole`; null draws the poster.
 * width, height: CSS pixels of a context that is scaled to them.
 */
export function drawThumbnail(
  pen: CanvasRenderingContext2D,
  thumb: Thumbnail,
  width: number,
  height: number,
  phase: number | null,
  inks: Inks,
  whole = false,
): void {
  pen.clearRect(0, 0, width, height);
  const poses = whole ? thumb.scrubPoses : thumb.loopPoses;
  const source = whole ? thumb.scrub : thumb.loop;
  const ground = whole ? thumb.scrubGround : thumb.loopGround;
  if (!poses) return;
  const exact = phase === null ? thumb.poster : phase * (poses - 1);
  const base = Math.min(Math.floor(exact), poses - 1);
  const share = exact - base;
  const tall = height * (1 - MARGIN - FLOOR);
  const scale = Math.min(tall, (width * 0.86) / thumb.aspect);
  const wide = scale * thumb.aspect;
  const [left, floor] = [(width - wide) / 2, height * (1 - FLOOR)];
  const topEdge = floor - scale;
  if (!thumb.face)
    drawFloor(
      pen,
      width,
      height,
      floor,
      slide(ground, base, share) * thumb.groundStep * scale,
      64 * thumb.groundStep * scale,
      inks.line,
    );
  const place = (point: number, axis: number): number => {
    const sample = (pose: number) =>
      numberAt(source, (Math.max(0, Math.min(poses - 1, pose)) * thumb.points + point) * 2 + axis);
    return catmull(sample(base - 1), sample(base), sample(base + 1), sample(base + 2), share);
  };
  const x = (point: number) => left + (place(point, 0) / 255) * wide;
  const y = (point: number) => topEdge + (place(point, 1) / 255) * scale;
  pen.lineCap = "round";
  pen.lineJoin = "round";
  if (thumb.markers) {
    pen.fillStyle = inks.sides[0];
    for (let point = 0; point < thumb.points; point++) {
      pen.beginPath();
      pen.arc(x(point), y(point), 1.8, 0, Math.PI * 2);
      pen.fill();
    }
    return;
  }
  for (const bone of thumb.bones) {
    pen.globalAlpha = 0.5 + 0.5 * Math.min(1, bone.depth / 40);
    pen.strokeStyle = inks.sides[bone.side] ?? inks.sides[0];
    pen.lineWidth = LIMB * Math.max(1, height / 150);
    pen.beginPath();
    pen.moveTo(x(bone.a), y(bone.a));
    pen.lineTo(x(bone.b), y(bone.b));
    pen.stroke();
  }
  pen.globalAlpha = 1;
  if (thumb.head >= 0 && !thumb.face) {
    pen.fillStyle = inks.sides[0];
    pen.beginPath();
    pen.arc(x(thumb.head), y(thumb.head), scale * 0.042, 0, Math.PI * 2);
    pen.fill();
  }
}

function drawFloor(
  pen: CanvasRenderingContext2D,
  width: number,
  height: number,
  floor: number,
  way: number,
  spacing: number,
  line: string,
): void {
  pen.strokeStyle = line;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(0, Math.round(floor) + 0.5);
  pen.lineTo(width, Math.round(floor) + 0.5);
  // 32 steps, or so many times more that ticks still fit where the way begins again, at 256.
  let gap = spacing / 2;
  while (gap < 24 && gap < 4 * spacing) gap *= 2;
  const slant = (height - floor) * 0.9;
  for (let at = -((way % gap) + gap); at < width + gap; at += gap) {
    pen.moveTo(at, height);
    pen.lineTo(at + slant, floor);
  }
  pen.stroke();
}

/** Ground travelled, between poses, across the wrap at 256. */
function slide(ground: Uint8Array, base: number, share: number): number {
  const from = ground[base] ?? 0;
  const to = ground[Math.min(base + 1, ground.length - 1)] ?? from;
  return from + (((to - from + 384) % 256) - 128) * share;
}

function catmull(a: number, b: number, c: number, d: number, t: number): number {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}
