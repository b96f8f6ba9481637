import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { nearestMark, stills } from "./snapping";

describe("edges", () => {
  it("snap to the nearest mark that is near enough", () => {
    expect(nearestMark(10, [3, 8, 11, 40], 3)).toBe(11);
    expect(nearestMark(10, [3, 8, 40], 2)).toBe(8);
    expect(nearestMark(10, [3, 40], 2)).toBeNull();
    expect(nearestMark(10, [], 9)).toBeNull();
  });

  it("find where the body is slowest, and no trembling", () => {
    const speeds = Float32Array.from(
      { length: 200 },
      (_, row) => 1 - Math.cos((row - 30) / 10) + 0.01 * Math.sin(row * 2.1),
    );
    const found = stills(speeds, 2, 60);
    expect(found.length).toBe(3);
    [30, 92.8, 155.7].forEach((row, place) =>
      expect(Math.abs(numberAt(found, place) - row * 2)).toBeLessThanOrEqual(4),
    );
    expect(stills(new Float32Array(50), 1, 30)).toEqual([]);
    expect(stills(new Float32Array(0), 1, 30)).toEqual([]);
  });
});
