/** Where the ground is, and its grid. */
import { numberAt } from "../../../lists";
import type { Skeleton } from "../../../motion/body/skeleton";
import { number } from "../../../words";

/** Height of the ground, metres from the clip's origin: the lowest that feet come, or zero of the file where it is near. */
export function floorOf(skeleton: Skeleton, values: Float32Array): number {
  const axis = skeleton.zUp ? 2 : 1;
  let least = Infinity;
  for (let at = axis; at < values.length; at += 3) if (numberAt(values, at) < least) least = numberAt(values, at);
  if (!Number.isFinite(least)) return 0;
  const zero = -numberAt(skeleton.view.origin, axis) * skeleton.metres;
  const lowest = least * skeleton.metres;
  return Math.abs(lowest - zero) < 0.12 * skeleton.height ? zero : lowest;
}

/** A step of the grid that suits a body: a third of its height or so, 1, 2 or 5 times a power of ten. */
export function niceStep(height: number): number {
  const wanted = height / 3.2;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [1, 2, 5, 10]
    .map((one) => one * power)
    .reduce((best, one) => (Math.abs(one - wanted) < Math.abs(best - wanted) ? one : best));
}

export const metresText = (metres: number): string =>
  metres < 1 ? `${number(metres * 100, 1)} cm` : `${number(metres, 2)} m`;
