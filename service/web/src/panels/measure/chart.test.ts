import { describe, expect, it, test } from "vitest";
import { bandPath, BOX, extentOf, nearest, pathOf, ticksOf, xAt, yAt } from "./chart";

test("an extent holds all known values", () => {
  const [low, high] = extentOf([
    [1, null, 3],
    [-2, 0],
  ]);
  expect(low).toBeLessThan(-2);
  expect(high).toBeGreaterThan(3);
  expect(extentOf([[null]])).toEqual([0, 1]);
  const [less, more] = extentOf([[5, 5]]);
  expect(less).toBeLessThan(5);
  expect(more).toBeGreaterThan(5);
});

describe("ticks", () => {
  it.each([
    [0, 1],
    [-13.2, 57],
    [0.0001, 0.00034],
    [1e6, 1.5e6],
    [-1, 1],
  ])("of %f to %f are few, round and within", (low, high) => {
    const ticks = ticksOf([low, high]);
    expect(ticks.length).toBeGreaterThan(1);
    expect(ticks.length).toBeLessThan(7);
    for (const tick of ticks) {
      expect(tick).toBeGreaterThanOrEqual(low);
      expect(tick).toBeLessThanOrEqual(high);
    }
  });
});

test("paths break at gaps, and the band with them", () => {
  const extent = [0, 10] as const;
  expect(pathOf(BOX, extent, [1, 2, null, 3]).match(/[ML]/g)).toEqual(["M", "L", "M"]);
  expect(bandPath(BOX, extent, [0, 0, null, 1], [2, 2, null, 3]).match(/M/g)).toHaveLength(2);
  expect(bandPath(BOX, extent, [null], [null])).toBe("");
  expect(pathOf(BOX, extent, [0])).toBe(`M${xAt(BOX, 0).toFixed(1)} ${yAt(BOX, extent, 0).toFixed(1)}`);
});

test("the nearest curve is found by its place, and none far away", () => {
  const extent = [0, 10] as const;
  const curves = [Array<number>(101).fill(2), Array<number>(101).fill(8), Array<null>(101).fill(null)];
  const x = xAt(BOX, 50);
  expect(nearest(BOX, extent, curves, [x, yAt(BOX, extent, 7.8)])).toBe(1);
  expect(nearest(BOX, extent, curves, [x, yAt(BOX, extent, 2.2)])).toBe(0);
  expect(nearest(BOX, extent, curves, [x, yAt(BOX, extent, 5)])).toBe(-1);
});
