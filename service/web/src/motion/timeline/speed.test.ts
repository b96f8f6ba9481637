import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { speedOf } from "./speed";

describe("the speed of points", () => {
  it("is the mean way to the next row, without what was not recorded", () => {
    for (let seed = 0; seed < 40; seed++) {
      const draw = random(seed);
      const [rows, points] = [draw.whole(0, 12), draw.whole(1, 5)];
      const values = Float32Array.from({ length: rows * points * 3 }, () => (draw() < 0.05 ? NaN : draw() * 10));
      const point = (row: number, at: number) => [
        ...values.subarray((row * points + at) * 3, (row * points + at) * 3 + 3),
      ];
      const found = speedOf({}, values, points);
      expect(found.length).toBe(rows);
      for (let row = 0; row + 1 < rows; row++) {
        const ways = Array.from({ length: points }, (_, at) =>
          Math.hypot(...point(row, at).map((one, axis) => numberAt(point(row + 1, at), axis) - one)),
        ).filter((one) => !Number.isNaN(one));
        expect(found[row]).toBeCloseTo(ways.length ? ways.reduce((sum, one) => sum + one, 0) / ways.length : 0, 4);
      }
      if (rows > 1) expect(found[rows - 1]).toBe(found[rows - 2]);
    }
  });

  it("is computed once for the same numbers, and anew for others", () => {
    const owner = {};
    const values = new Float32Array([0, 0, 0, 3, 4, 0]);
    expect([...speedOf(owner, values, 1)]).toEqual([5, 5]);
    expect(speedOf(owner, values, 1)).toBe(speedOf(owner, values, 1));
    expect([...speedOf(owner, new Float32Array([0, 0, 0, 0, 0, 1]), 1)]).toEqual([1, 1]);
  });
});
