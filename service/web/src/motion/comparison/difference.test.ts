import { itemAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { apart } from "./difference";

describe("two motions of one skeleton", () => {
  it("are told apart by joint and row, the farthest first", () => {
    const now = new Float32Array(4 * 3 * 3);
    const then = now.slice();
    then[(2 * 3 + 1) * 3] = 3; // row 2, joint 1
    then[(2 * 3 + 1) * 3 + 1] = 4;
    then[(3 * 3 + 0) * 3 + 2] = 1; // row 3, joint 0
    then[(1 * 3 + 2) * 3] = 9; // a tip
    then[0] = NaN; // not seen
    const found = apart(now, then, 3, 2, 0.01);
    expect(found.map(({ joint, at }) => [joint, at])).toEqual([
      [1, 2],
      [0, 3],
    ]);
    expect(itemAt(found, 0).most).toBeCloseTo(0.05);
    expect([...itemAt(found, 0).away].map((one) => Math.round(one * 1000))).toEqual([0, 0, 50, 0]);
    expect(apart(now, now, 3, 3, 1)).toEqual([]);
  });
});
