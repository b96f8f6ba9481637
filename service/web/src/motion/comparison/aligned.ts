/** Frames of two revisions that are the same ones: what an edit kept, wherever it stands now. */
import type { Source } from "../loading/blocks";

/** Consecutive frames of both, from 1. */
export interface Kept {
  before: number;
  after: number;
  count: number;
}
/** Position (from 0) in the other revision of the frame at a position in this one; null where it is not there. */
export type At = (frame: number) => number | null;

export const turned = (kept: readonly Kept[]): Kept[] =>
  kept.map(({ before, after, count }) => ({ before: after, after: before, count }));

/** From positions in the later revision to those in the earlier one. */
export function alignedBy(kept: readonly Kept[]): At {
  const runs = [...kept].sort((a, b) => a.after - b.after);
  return (frame) => {
    let [low, high] = [0, runs.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (runs[middle]!.after <= frame + 1) low = middle + 1;
      else high = middle;
    }
    const run = runs[low - 1];
    return run && frame + 1 < run.after + run.count ? run.before + frame - run.after : null;
  };
}

/** What is compared: what was kept. Where nothing was, and both are as long, frames by their position. */
export function pairsOf(kept: readonly Kept[], before: number, after: number): Kept[] {
  return kept.length || before !== after ? [...kept] : [{ before: 1, after: 1, count: before }];
}

/** Every `step`-th frame of the later revision as the earlier one has it: (rows, stride), NaN where it has none. shift: added to
 * positions, as each revision has an origin of its own. */
export async function earlierRows(
  source: Pick<Source<Float32Array>, "stride" | "fetch">,
  kept: readonly Kept[],
  frames: number,
  step: number,
  shift: readonly number[],
  signal: AbortSignal,
): Promise<Float32Array> {
  const { stride } = source;
  const rows = Math.ceil(frames / step);
  const found = new Float32Array(rows * stride).fill(NaN);
  for (const { before, after, count } of kept) {
    const row = Math.ceil((after - 1) / step);
    const late = row * step - (after - 1);
    if (late >= count) continue;
    const values = await source.fetch({ first: before + late, last: before + count - 1, step }, signal);
    for (let at = 0; at < values.length; at++) found[row * stride + at] = values[at]! + shift[at % 3]!;
  }
  return found;
}
