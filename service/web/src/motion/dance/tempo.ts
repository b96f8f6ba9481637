/** A tempo that is tapped. */
import { numberAt } from "../../lists";

const LAST = 8; // intervals that count
const PAUSE = 2500; // ms after which tapping begins anew

/** Taps with one more at `now`, ms; those before a pause are forgotten. */
export function tapped(taps: readonly number[], now: number): number[] {
  const last = taps.at(-1);
  return [...(last !== undefined && now - last <= PAUSE ? taps.slice(-LAST) : []), now];
}

/** Beats a minute of taps in ms: the median of the last eight intervals; null for fewer than two taps. */
export function tempoOf(taps: readonly number[]): number | null {
  const between = taps
    .slice(1)
    .map((tap, at) => tap - numberAt(taps, at))
    .slice(-LAST)
    .sort((a, b) => a - b);
  if (!between.length) return null;
  const middle = between.length >> 1;
  const median = between.length % 2 ? between[middle] : (numberAt(between, middle - 1) + numberAt(between, middle)) / 2;
  return median !== undefined && median > 0 ? 60_000 / median : null;
}
