import { describe, expect, it } from "vitest";
import { alignedBy, earlierRows, pairsOf, turned } from "./aligned";

const frames = (count: number, at: (frame: number) => number | null) =>
  Array.from({ length: count }, (_, frame) => at(frame));

describe("frames of two revisions", () => {
  it("are the same ones after a crop", () => {
    const kept = [{ before: 21, after: 1, count: 3 }];
    expect(frames(4, alignedBy(kept))).toEqual([20, 21, 22, null]);
    const back = alignedBy(turned(kept));
    expect([back(19), back(20), back(22), back(23)]).toEqual([null, 0, 2, null]);
  });

  it("are the same ones after frames were taken out, put in and moved", () => {
    expect(
      frames(
        5,
        alignedBy([
          { before: 1, after: 1, count: 2 },
          { before: 5, after: 3, count: 3 },
        ]),
      ),
    ).toEqual([0, 1, 4, 5, 6]);
    expect(
      frames(
        5,
        alignedBy([
          { before: 1, after: 1, count: 2 },
          { before: 3, after: 5, count: 1 },
        ]),
      ),
    ).toEqual([0, 1, null, null, 2]);
    expect(
      frames(
        4,
        alignedBy([
          { before: 3, after: 1, count: 2 },
          { before: 1, after: 3, count: 2 },
        ]),
      ),
    ).toEqual([2, 3, 0, 1]);
    expect(alignedBy([])(0)).toBe(null);
  });

  it("are paired by position only where none was kept and both are as long", () => {
    expect(pairsOf([], 3, 3)).toEqual([{ before: 1, after: 1, count: 3 }]);
    expect(pairsOf([], 3, 4)).toEqual([]);
  });

  it("are read as the earlier revision has them, at the rows of the later one", async () => {
    const source = {
      stride: 3,
      fetch: async ({ first, last, step }: { first: number; last?: number; step?: number }) =>
        Float32Array.from({ length: Math.floor((last! - first) / step!) + 1 }, (_, row) => first + row * step!).reduce(
          (all, one) => Float32Array.from([...all, one, 0, 0]),
          new Float32Array(),
        ),
    };
    const kept = [
      { before: 11, after: 2, count: 6 },
      { before: 30, after: 9, count: 1 },
    ];
    const rows = await earlierRows(source, kept, 9, 2, [100, 0, 0], new AbortController().signal);
    // Rows are frames 1, 3, 5, 7, 9 of the later one.
    expect([...rows].filter((_, at) => at % 3 === 0)).toEqual([NaN, 112, 114, 116, 130]);
  });
});
