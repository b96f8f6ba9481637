import { describe, expect, it } from "vitest";
import { middleOf } from "./middle";

describe("the middle of a body", () => {
  it("goes where the body goes, though its first joint stands still", () => {
    const at = (x: number) => Float32Array.from([0, 0, 0, x, 1, 0, x, 2, 0]);
    expect(middleOf(at(6), 3)![0] - middleOf(at(0), 3)![0]).toBeCloseTo(4);
  });

  it("is of the joints that are there, and of nothing where there is none", () => {
    expect(middleOf(Float32Array.from([NaN, NaN, NaN, 2, 4, 6, 9, 9, 9]), 2)).toEqual([2, 4, 6]);
    expect(middleOf(Float32Array.from([NaN, 0, 0]), 1)).toBe(null);
    expect(middleOf(new Float32Array(0), 0)).toBe(null);
  });
});
