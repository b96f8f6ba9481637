import { describe, expect, it } from "vitest";
import type { Run } from "./answered";
import { cardsOf, nextOrder, scaleOf, sortRuns } from "./rangeTable";

const run = (document: string, frames: number, mean?: number): Run => ({
  document,
  name: document,
  revision: 1,
  first: 1,
  last: frames,
  first_id: "1",
  last_id: String(frames),
  frames,
  mean: mean ?? null,
});

describe("frame ranges", () => {
  const runs = [run("b", 3, 0.5), run("a", 9), run("b", 5, 2), run("c", 1, -1)];

  it("are sorted by any column, those without a value last", () => {
    const names = (found: Run[]) => found.map((one) => `${one.name}${one.frames}`).join(" ");
    expect(names(sortRuns(runs, null))).toBe("b3 a9 b5 c1");
    expect(names(sortRuns(runs, { column: "mean", falling: true }))).toBe("b5 b3 c1 a9");
    expect(names(sortRuns(runs, { column: "mean", falling: false }))).toBe("c1 b3 b5 a9");
    expect(names(sortRuns(runs, { column: "name", falling: false }))).toBe("a9 b3 b5 c1");
    expect(names(runs)).toBe("b3 a9 b5 c1");
  });

  it("turn round with each click on the head, and back to the order of the answer", () => {
    const falls = nextOrder(null, "mean");
    expect(falls).toEqual({ column: "mean", falling: true });
    expect(nextOrder(falls, "mean")).toEqual({ column: "mean", falling: false });
    expect(nextOrder({ column: "mean", falling: false }, "mean")).toBeNull();
    expect(nextOrder(falls, "name")).toEqual({ column: "name", falling: false });
  });

  it("are cards of many clips", () => {
    expect(cardsOf(runs)).toEqual([0, 1, 2, 3]);
    expect(cardsOf(runs, 3)).toEqual([0, 1, 3]);
    expect(cardsOf(runs, 2)).toEqual([0, 1]);
  });
});

describe("the slider of a threshold", () => {
  it("covers the values of most frames, and the value that is set", () => {
    const range = { least: 0, low: 0.1, high: 3.1, most: 40 };
    expect(scaleOf(range, [0, 5], 1)).toEqual({ min: 0, max: 4.6, step: 0.05 });
    expect(scaleOf(range, [0, 5], 12)).toMatchObject({ min: 0, max: 12 });
    expect(scaleOf(null, [0, 5], Number.NaN)).toEqual({ min: 0, max: 5, step: 0.05 });
    expect(scaleOf({ least: 2, low: 2, high: 2, most: 2 }, [0, 5], 1)).toMatchObject({ min: 0, max: 5 });
  });
});
