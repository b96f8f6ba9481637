import { describe, expect, it } from "vitest";
import { anchorOf, frameBeside, type Timed } from "./sync";

const clip = (frames: number, perSecond: number, ...labels: [string, number, number][]): Timed => ({
  frames,
  perSecond,
  labels: labels.map(([name, first, last]) => ({ name, first, last })),
});
const here = clip(400, 120, ["walk", 101, 200], ["jump", 241, 280], ["walk", 301, 400]);
const there = clip(100, 30, ["jump", 11, 20], ["walk", 41, 60], ["sit", 90, 100]);

describe("two clips side by side", () => {
  it("run by the clock, or frame by frame, and stay at their ends", () => {
    expect([0, 3, 4, 120, 399].map((frame) => frameBeside(here, there, "time", frame))).toEqual([0, 0, 1, 30, 99]);
    expect([0, 3, 99, 399].map((frame) => frameBeside(here, there, "frame", frame))).toEqual([0, 3, 99, 99]);
    expect(frameBeside(there, here, "time", 99)).toBe(396);
    expect(frameBeside(there, clip(0, 30), "time", 9)).toBe(0);
  });

  it("begin together where spans of the same name begin", () => {
    expect(frameBeside(here, there, "span", 100)).toBe(40);
    expect(frameBeside(here, there, "span", 104)).toBe(41);
    expect(frameBeside(here, there, "span", 240)).toBe(10);
    expect(frameBeside(here, there, "span", 300), "the second walk meets the only one").toBe(40);
    expect(frameBeside(here, there, "span", 60), "before the first, on its way there").toBe(30);
    expect(frameBeside(here, there, "span", 0)).toBe(15);
  });

  it("begin at their beginnings where no name is shared", () => {
    expect(anchorOf(here, clip(50, 30, ["sit", 9, 12]), "span", 120)).toEqual({ here: 0, there: 0 });
  });
});
