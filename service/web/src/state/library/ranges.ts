/** Ranges of numbers, as lists take them: "2..10", "2..", "..10". */
import { numberAt } from "../../lists";
export type Range = readonly [least: number | null, most: number | null];

export function readRange(text: string): Range {
  const [least = "", most = ""] = text.split("..");
  const value = (one: string) => (one.trim() === "" || !Number.isFinite(Number(one)) ? null : Number(one));
  return [value(least), value(most)];
}

const exact = (value: number | null): string => (value === null ? "" : String(Number(value.toPrecision(6))));

/** null: no condition at all. What is given the wrong way round is turned. */
export function writeRange([least, most]: Range): string | null {
  if (least === null && most === null) return null;
  const [low, high] = least !== null && most !== null && least > most ? [most, least] : [least, most];
  return `${exact(low)}..${exact(high)}`;
}

/** The range of bins `from` to `to`, in either order: open where it reaches an end, so that rounding leaves out nothing. */
export function rangeOfBins(edges: readonly number[], from: number, to: number): Range {
  const [first, last] = [Math.min(from, to), Math.max(from, to)];
  return [first <= 0 ? null : numberAt(edges, first), last >= edges.length - 2 ? null : numberAt(edges, last + 1)];
}

/** Whether a bin is within a range: its middle is. */
export function isInRange(edges: readonly number[], bin: number, [least, most]: Range): boolean {
  const middle = (numberAt(edges, bin) + numberAt(edges, bin + 1)) / 2;
  return (least === null || middle >= least) && (most === null || middle <= most);
}
