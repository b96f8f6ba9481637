import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { clock } from "./clock";

describe("the time of a frame", () => {
  it("is minutes and seconds", () => {
    expect(clock(0, 60)).toBe("0:00.000");
    expect(clock(121, 120)).toBe("0:01.008");
    expect(clock(72_000, 120)).toBe("10:00.000");
  });

  it("never has sixty seconds", () => {
    for (const rate of [23.976, 29.97, 59.94, 120.00048, 7000]) {
      const shown = Array.from({ length: 9000 }, (_, frame) => clock(Math.floor(rate * 60) - 4500 + frame, rate));
      expect(shown.filter((one) => one.includes(":60"))).toEqual([]);
    }
  });

  it("goes on, whatever the rate", () => {
    for (const spacing of [1 / 24, 1 / 25, 1 / 30, 0.0333333, 0.0083333, 1 / 120, 0.008333, 1 / 59.94]) {
      const parts = Array.from({ length: 700 }, (_, frame) =>
        clock(frame, 1 / spacing, true)
          .split(":")
          .map(Number),
      );
      const counted = parts.map(
        ([hours = 0, minutes = 0, seconds = 0, frame = 0]) => ((hours * 60 + minutes) * 60 + seconds) * 1000 + frame,
      );
      expect(counted.filter((one, index) => index && one <= numberAt(counted, index - 1))).toEqual([]);
      const most = Math.round(1 / spacing);
      expect(parts.filter(([, , , frame = 0]) => frame >= most)).toEqual([]);
    }
  });

  it("as timecode has the frame of the second", () => {
    expect(clock(0, 30, true)).toBe("00:00:00:00");
    expect(clock(65, 30, true)).toBe("00:00:02:05");
    expect(clock(120, 1 / 0.0083333, true)).toBe("00:00:01:00");
    expect(clock(30 * 3600 + 30 * 60 + 31, 30, true)).toBe("01:01:01:01");
  });
});
