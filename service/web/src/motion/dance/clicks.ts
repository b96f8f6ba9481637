/** Clicks of a grid of beats, a little ahead of the time at which they sound. */
import { numberAt } from "../../lists";

export interface Click {
  time: number;
  first: boolean;
}

/** Beats of a grid from `from` on and before `to`, seconds; `first`: the first of a bar of four. */
export function clicksBetween(grid: ArrayLike<number>, from: number, to: number): Click[] {
  let [low, high] = [0, grid.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numberAt(grid, middle) < from) low = middle + 1;
    else high = middle;
  }
  const found: Click[] = [];
  for (let at = low; at < grid.length && numberAt(grid, at) < to; at++)
    found.push({ time: numberAt(grid, at), first: at % 4 === 0 });
  return found;
}
