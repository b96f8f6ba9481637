import { describe, expect, it } from "vitest";
import { entryOf, itemAt, numberAt } from "./lists";

describe("reading from a list", () => {
  it("gives what is there", () => {
    expect(numberAt([4, 0, 6], 1)).toBe(0);
    expect(numberAt(Float32Array.of(1, 2), 1)).toBe(2);
    expect(itemAt(["a", "b"], 1)).toBe("b");
    expect(itemAt([undefined, 1], 0)).toBeUndefined();
    expect(entryOf({ left: 1 }, "left")).toBe(1);
  });

  it.each([-1, 2, 0.5 + 1e9, NaN])("marks a number at %s as missing, and refuses an item there", (index) => {
    expect(numberAt([1, 2], index)).toBeNaN();
    expect(() => itemAt(["a", "b"], index)).toThrow(RangeError);
  });

  it("refuses keys that every object inherits", () => {
    expect(() => entryOf({}, "constructor")).toThrow(RangeError);
  });
});
