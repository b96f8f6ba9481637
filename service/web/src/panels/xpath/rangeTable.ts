/** Frame ranges in a table: their order, those that are shown as cards; and the slider that changes them. Pure functions. */
import type { Run } from "./answered";

const CARDS = 12;
const STEPS = 100;
export const COLUMNS = ["name", "first", "last", "frames", "least", "most", "mean"] as const;
export type Column = (typeof COLUMNS)[number];
export interface Order {
  column: Column;
  falling: boolean;
}

const valueOf = (run: Run, column: Column): number | string | null | undefined => {
  if (column === "least") return run.range?.[0];
  return column === "most" ? run.range?.[1] : run[column];
};

/** Ranges by a column; those without a value last, equal ones as the answer has them. null: as the answer has them. */
export function sortRuns(runs: Run[], order: Order | null): Run[] {
  if (!order) return runs;
  const { column, falling } = order;
  return [...runs].sort((one, other) => {
    const [a, b] = [valueOf(one, column), valueOf(other, column)];
    if (a === b) return 0;
    if (a === null || a === undefined) return 1;
    if (b === null || b === undefined) return -1;
    const rises = typeof a === "string" ? a.localeCompare(String(b)) : a - Number(b);
    return falling ? -rises : rises;
  });
}

/** Greatest first, then least first, then as the answer has them; names from A. */
export function nextOrder(order: Order | null, column: Column): Order | null {
  const begins = column !== "name";
  if (order?.column !== column) return { column, falling: begins };
  return order.falling === begins ? { column, falling: !begins } : null;
}

/** Places of the runs that are cards: the first of each clip before a second one of any. */
export function cardsOf(runs: readonly Pick<Run, "document">[], most = CARDS): number[] {
  const first: number[] = [];
  const others: number[] = [];
  const seen = new Set<string>();
  runs.forEach(({ document }, at) => {
    (seen.has(document) ? others : first).push(at);
    seen.add(document);
  });
  return [...first.slice(0, most), ...others.slice(0, Math.max(0, most - first.length))].sort((a, b) => a - b);
}

/** Ends and step of a slider around the values that most frames have. */
export function scaleOf(
  range: { least: number; low: number; high: number; most: number } | null,
  [usualLeast, usualMost]: [number, number],
  value: number,
): { min: number; max: number; step: number } {
  const spread = range ? range.high - range.low : 0;
  const [least, most] =
    range && spread > 0
      ? [Math.max(range.least, range.low - spread / 2), Math.min(range.most, range.high + spread / 2)]
      : [usualLeast, usualMost];
  const rough = (most - least) / STEPS;
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = ([1, 2, 5].find((one) => one * unit >= rough) ?? 10) * unit;
  const within = Number.isFinite(value) ? value : least;
  return {
    min: tidy(Math.floor(Math.min(least, within) / step) * step),
    max: tidy(Math.ceil(Math.max(most, within) / step) * step),
    step: tidy(step),
  };
}

/** Without the tail of binary fractions. */
export const tidy = (value: number): number => Number(value.toPrecision(10));
