import { describe, expect, it } from "vitest";
import { holding } from "./holding";

describe("a frame that is held", () => {
  it.each([0, 1, 2, 3, 7, 8, 100, 1000])("stands for %i more, in few edits", (more) => {
    const edits = holding(3, more);
    const frames = ["a", "b", "c", "d"];
    for (const { first, last, at } of edits) frames.splice(at - 1, 0, ...frames.slice(first - 1, last));
    expect(frames.join("")).toBe(`ab${"c".repeat(more + 1)}d`);
    expect(edits.length).toBeLessThanOrEqual(Math.ceil(Math.log2(more + 1)));
  });
});
