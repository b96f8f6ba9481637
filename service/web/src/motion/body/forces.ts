/** Ground reaction forces as arrows, and the outlines of the plates that measure them. Pure functions. */
import { numberAt } from "../../lists";
import type { SkeletonView } from "./skeleton";

/** Length of the arrow of one newton. */
export const METRES_PER_NEWTON = 0.001;
/** Numbers of a plate in a frame: force (N), then centre of pressure (m). */
const OF_PLATE = 6;
const CORNERS = 4;

/** The quantities of a plate, in the order of its numbers. */
export const quantitiesOf = (plate: string): string[] =>
  ["force", "cop"].flatMap((kind) => ["x", "y", "z"].map((axis) => `${kind}:${plate},${axis}`));

/** Start and end (x y z each) of the arrow of each known force of a frame: from the clip's origin, in its unit. numbers:
 * of all plates. metres: of the unit. */
export function arrowsOf(numbers: ArrayLike<number>, origin: ArrayLike<number>, metres: number): Float32Array {
  const arrows: number[] = [];
  for (let from = 0; from + OF_PLATE <= numbers.length; from += OF_PLATE) {
    const axes = [0, 1, 2];
    const starts = axes.map((axis) => numberAt(numbers, from + 3 + axis) / metres - numberAt(origin, axis));
    const ends = axes.map(
      (axis) => numberAt(starts, axis) + (numberAt(numbers, from + axis) * METRES_PER_NEWTON) / metres,
    );
    if (ends.every(Number.isFinite)) arrows.push(...starts, ...ends);
  }
  return Float32Array.from(arrows);
}

/** Start and end of each side of each plate: from the clip's origin, in its unit. */
export function outlinesOf({ plates, origin }: Pick<SkeletonView, "plates" | "origin">): Float32Array {
  const sides = plates.flatMap(({ corners }) =>
    corners.flatMap((corner, at) => [...corner, ...(corners[(at + 1) % CORNERS] ?? [])]),
  );
  return Float32Array.from(sides, (value, at) => value - numberAt(origin, at % 3));
}
