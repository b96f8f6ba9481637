/** Phases of a reach: moments that belong to one another in motions of different length, and attributes of examples. */
import { numberAt } from "../../lists";

/** Moments of a motion in frames from its first: 0, t1, t2, end. */
export type Moments = readonly [number, number, number, number];

/** The frame of another motion at which it is in the same phase, straight between the moments. */
export function samePhase(frame: number, from: Moments, to: Moments): number {
  let at = 1;
  while (at < 3 && frame > numberAt(from, at)) at++;
  const span = numberAt(from, at) - numberAt(from, at - 1);
  const share = span > 0 ? Math.max(0, Math.min(1, (frame - numberAt(from, at - 1)) / span)) : 0;
  return numberAt(to, at - 1) + share * (numberAt(to, at) - numberAt(to, at - 1));
}

/** A step for a slider over a span: 1, 2 or 5 times a power of ten, about a hundredth of it. */
export function stepOver(span: number): number {
  if (!(span > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(span / 100));
  return [5, 2, 1].map((one) => one * power).find((one) => one <= (span / 100) * 1.001)!;
}

/** A value on the grid of a step, without digits that are none. */
export const onStep = (value: number, step: number): number =>
  Number((Math.round(value / step) * step).toPrecision(10));

/** The corners of the convex hull of points (n, 2), counted round; fewer than three points are their own. */
export function hullOf(points: readonly (readonly [number, number])[]): [number, number][] {
  const sorted = points
    .map(([x, y]) => [x, y] as [number, number])
    .sort((one, other) => one[0] - other[0] || one[1] - other[1]);
  if (sorted.length < 3) return sorted;
  const half = (list: [number, number][]) => {
    const found: [number, number][] = [];
    for (const one of list) {
      while (found.length > 1 && turn(found.at(-2)!, found.at(-1)!, one) <= 0) found.pop();
      found.push(one);
    }
    return found.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.toReversed())];
}

const turn = (a: readonly number[], b: readonly number[], c: readonly number[]): number =>
  (numberAt(b, 0) - numberAt(a, 0)) * (numberAt(c, 1) - numberAt(a, 1)) -
  (numberAt(b, 1) - numberAt(a, 1)) * (numberAt(c, 0) - numberAt(a, 0));

/** How dense values lie over a range: `bins` heights from 0 to 1, smoothed over a fortieth of it. */
export function densityOf(values: ArrayLike<number>, low: number, high: number, bins = 80): Float64Array {
  const found = new Float64Array(bins);
  const width = (high - low) / 40 || 1;
  let most = 0;
  for (let bin = 0; bin < bins; bin++) {
    const at = low + ((bin + 0.5) * (high - low)) / bins;
    for (let index = 0; index < values.length; index++)
      found[bin] = numberAt(found, bin) + Math.exp(-0.5 * ((numberAt(values, index) - at) / width) ** 2);
    if (numberAt(found, bin) > most) most = numberAt(found, bin);
  }
  return most ? found.map((one) => one / most) : found;
}
