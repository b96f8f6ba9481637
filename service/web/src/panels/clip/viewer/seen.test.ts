import { describe, expect, it } from "vitest";
import { nearestSeen } from "./seen";

const gone = [NaN, NaN, NaN];
const overview = (rows: number[][], step = 1) => ({ values: Float32Array.from(rows.flat()), step });

describe("frames that show nothing", () => {
  it("are those without any known point", () => {
    const known = Float32Array.from([...gone, 1, 2, 3]);
    expect(nearestSeen(known, overview([[...gone, 1, 2, 3]]), 0, 2)).toBeNull();
    expect(nearestSeen(null, overview([gone]), 0, 1)).toBeNull();
  });

  it("lead to the nearest frame that shows something, of those known", () => {
    const none = Float32Array.from(gone);
    const rows = [gone, gone, [1, 2, 3], gone, gone, gone, [4, 5, 6]];
    expect(nearestSeen(none, overview(rows), 0, 1)).toBe(2);
    expect(nearestSeen(none, overview(rows), 5, 1)).toBe(6);
    expect(nearestSeen(none, overview(rows, 10), 0, 1)).toBe(20);
  });

  it("lead nowhere where no frame does, or none is known", () => {
    const none = Float32Array.from(gone);
    expect(nearestSeen(none, overview([gone, gone]), 1, 1)).toBe(-1);
    expect(nearestSeen(none, null, 1, 1)).toBe(-1);
    expect(nearestSeen(Float32Array.from([]), overview([]), 0, 0)).toBe(-1);
  });
});
