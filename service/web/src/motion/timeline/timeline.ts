/** The arithmetic of timelines: frames to pixels, steps of a ruler, lanes for spans that overlap. */
import { itemAt } from "../../lists";

export interface Range {
  first: number;
  last: number;
} // frames from 0; last is one past the end

export const toX = (frame: number, range: Range, width: number): number =>
  ((frame - range.first) / (range.last - range.first)) * width;
export const toFrame = (x: number, range: Range, width: number): number =>
  range.first + (x / width) * (range.last - range.first);

/** Frames between marks of a ruler that are at least `least` pixels apart: 1, 2, 5, 10, 20, 50, … */
export function rulerStep(range: Range, width: number, least: number): number {
  const wanted = ((range.last - range.first) / Math.max(1, width)) * least;
  let power = 1;
  while (power * 10 <= wanted) power *= 10;
  for (const one of [1, 2, 5, 10]) if (one * power >= wanted) return one * power;
  return power * 10;
}

/** The lane of each span, so that none covers another: the first lane that is free where it begins. */
export function lanes(spans: readonly { first: number; last: number }[]): number[] {
  const order = spans
    .map((_, index) => index)
    .sort((a, b) => itemAt(spans, a).first - itemAt(spans, b).first || itemAt(spans, b).last - itemAt(spans, a).last);
  const ends: number[] = [];
  const found = new Array<number>(spans.length).fill(0);
  for (const index of order) {
    let lane = ends.findIndex((end) => end < itemAt(spans, index).first);
    if (lane < 0) lane = ends.push(0) - 1;
    ends[lane] = itemAt(spans, index).last;
    found[index] = lane;
  }
  return found;
}

/** Zoom about a frame that stays where it is; kept inside the clip and not below `least` frames. */
export function zoomed(range: Range, about: number, factor: number, frames: number, least = 8): Range {
  const size = Math.min(frames, Math.max(Math.min(least, frames), (range.last - range.first) * factor));
  const share = (about - range.first) / (range.last - range.first);
  const first = Math.max(0, Math.min(frames - size, about - share * size));
  return { first, last: first + size };
}

export function moved(range: Range, by: number, frames: number): Range {
  const size = range.last - range.first;
  const first = Math.max(0, Math.min(frames - size, range.first + by));
  return { first, last: first + size };
}
