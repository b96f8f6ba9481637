import { describe, expect, it } from "vitest";
import { isInRange, rangeOfBins, readRange, writeRange } from "./ranges";

const EDGES = [0.5, 5, 50, 500.1234567];

describe("ranges of numbers", () => {
  it("are written as lists take them, and read again", () => {
    for (const text of ["2..10", "2..", "..10", "0.5..5", "-3..-1"]) expect(writeRange(readRange(text))).toBe(text);
    expect(writeRange([10, 2])).toBe("2..10");
    expect(writeRange([null, null])).toBe(null);
    expect(readRange("x..")).toEqual([null, null]);
    expect(readRange("")).toEqual([null, null]);
  });

  it("of bins are open at the ends, where rounding would leave out the greatest", () => {
    expect(rangeOfBins(EDGES, 1, 1)).toEqual([5, 50]);
    expect(rangeOfBins(EDGES, 2, 1)).toEqual([5, null]);
    expect(rangeOfBins(EDGES, 0, 1)).toEqual([null, 50]);
    expect(rangeOfBins(EDGES, 0, 2)).toEqual([null, null]);
  });

  it("hold the bins that they were made of", () => {
    for (const [from, to] of [
      [0, 0],
      [0, 1],
      [1, 2],
      [2, 2],
    ]) {
      const range = rangeOfBins(EDGES, from!, to!);
      expect([0, 1, 2].filter((bin) => isInRange(EDGES, bin, range))).toEqual(
        [0, 1, 2].filter((bin) => bin >= from! && bin <= to!),
      );
    }
  });
});
