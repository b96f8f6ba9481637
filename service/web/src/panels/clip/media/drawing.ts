/** Angles and lengths drawn on a picture of a video. Points are in pixels of the picture, x right and y down. */
import { itemAt } from "../../../lists";

export type Point = readonly [number, number];
export type Kind = "angle" | "length";

export interface Drawing {
  id: number;
  kind: Kind;
  /** Of an angle: a leg's end, the corner, the other leg's end. Of a length: both ends. */
  points: readonly Point[];
  /** Of the picture in the video, in seconds: on others it is not shown. */
  time: number;
}

/** Seconds that a picture may be from the one that a drawing was made on: half of one at 25 a second. */
export const SAME_PICTURE = 0.02;

const between = (one: Point, other: Point): Point => [other[0] - one[0], other[1] - one[1]];

/** Degrees from 0 to 180 at the corner; NaN where an end lies on it. */
export function angleOf(points: readonly Point[]): number {
  const corner = itemAt(points, 1);
  const [a, b] = between(corner, itemAt(points, 0));
  const [c, d] = between(corner, itemAt(points, 2));
  if (!Math.hypot(a, b) || !Math.hypot(c, d)) return Number.NaN;
  return (Math.atan2(Math.abs(a * d - b * c), a * c + b * d) * 180) / Math.PI;
}

/** Pixels. */
export function lengthOf(points: readonly Point[]): number {
  return Math.hypot(...between(itemAt(points, 0), itemAt(points, 1)));
}

/** A new drawing to be dragged into place, a fifth of the picture wide: an angle in the middle, a length below it. */
export function drawingIn(kind: Kind, id: number, width: number, height: number, time: number): Drawing {
  const [x, y, part] = [width / 2, height / 2, Math.min(width, height) / 5];
  const points: Point[] =
    kind === "angle"
      ? [
          [x + part, y],
          [x, y],
          [x, y - part],
        ]
      : [
          [x - part, y + part],
          [x + part, y + part],
        ];
  return { id, kind, points, time };
}

/** The drawing with one point elsewhere, inside the picture. */
export function movePoint(one: Drawing, place: number, to: Point, width: number, height: number): Drawing {
  const inside: Point = [Math.max(0, Math.min(width, to[0])), Math.max(0, Math.min(height, to[1]))];
  return { ...one, points: one.points.map((point, index) => (index === place ? inside : point)) };
}

/** Seconds of the media at the first frame, where a moment of it is the same as a frame of the motion. */
export const offsetOf = (moment: number, frame: number, perSecond: number): number => moment - frame / perSecond;
