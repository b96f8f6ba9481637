import { describe, expect, it } from "vitest";
import { nextItem } from "./useRoving";

describe("arrows in a group", () => {
  it("go to the neighbour, and no farther than the ends", () => {
    expect(nextItem("ArrowDown", 1, 4)).toBe(2);
    expect(nextItem("ArrowRight", 3, 4)).toBe(3);
    expect(nextItem("ArrowUp", 1, 4)).toBe(0);
    expect(nextItem("ArrowLeft", 0, 4)).toBe(0);
  });
  it("Home and End go to the ends, other keys nowhere", () => {
    expect(nextItem("Home", 2, 4)).toBe(0);
    expect(nextItem("End", 2, 4)).toBe(3);
    expect(nextItem("Tab", 2, 4)).toBeNull();
  });
});
