import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { Grid } from "./grid";

const random = (seed: number) => () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;

describe("points found by their place", () => {
  it.each([1, 7, 500, 3000])("among %i, as looking at each", (count) => {
    const next = random(count);
    const places = Float32Array.from({ length: count * 2 }, (_, at) => (at % 2 ? next() * 3 : next() ** 3 * 100));
    const grid = new Grid(places);
    for (let trial = 0; trial < 300; trial++) {
      const [x, y, within] = [next() * 140 - 20, next() * 5 - 1, next() * 4];
      let [best, least] = [-1, within * within];
      for (let at = 0; at < count; at++) {
        const away = (numberAt(places, at * 2) - x) ** 2 + (numberAt(places, at * 2 + 1) - y) ** 2;
        if (away < least) [best, least] = [at, away];
      }
      const found = grid.nearest(x, y, within);
      const away = (at: number) => Math.hypot(numberAt(places, at * 2) - x, numberAt(places, at * 2 + 1) - y);
      if (best < 0) expect(found).toBe(-1);
      else expect(away(found)).toBeCloseTo(away(best), 6);
    }
  });

  it("on one spot, on a line, and none at all", () => {
    expect(new Grid(new Float32Array(0)).nearest(0, 0, 10)).toBe(-1);
    expect(new Grid(Float32Array.of(5, 5, 5, 5)).nearest(5.5, 5, 1)).toBeGreaterThanOrEqual(0);
    expect(new Grid(Float32Array.of(0, 1, 10, 1, 20, 1)).nearest(12, 1, 5)).toBe(1);
  });
});
