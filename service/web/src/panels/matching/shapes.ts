/** Paths to begin with. */
import { Path } from "../../motion/matching/goals";
import type { Point } from "../../motion/matching/library";

const RADIUS = 3;
const SIDE = 5;
const PLACES = 64;

const round = (place: (angle: number) => Point): Path =>
  new Path(Array.from({ length: PLACES + 1 }, (_, at) => place((2 * Math.PI * at) / PLACES)));

export const SHAPES = [
  { word: "label.circle", path: () => round((at) => [RADIUS * Math.sin(at), RADIUS - RADIUS * Math.cos(at)]) },
  { word: "label.square", path: () => new Path([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE], [0, 0]]) }, // prettier-ignore
  { word: "label.eight", path: () => round((at) => [1.3 * RADIUS * Math.sin(at), 0.65 * RADIUS * Math.sin(2 * at)]) },
] as const;
