import { describe, expect, it } from "vitest";
import { bodyOf, numbersOf, Preview, previewOf, stepFor, wholeOf, type Told } from "./preview";
import type { Skeleton } from "../body/skeleton";

const one = { points: 1 } as Skeleton;
const told = (more: Partial<Told> = {}): Told =>
  ({
    bones: ["Hips", "LeftLeg", "right_foot", "Head"],
    parents: [-1, 0, 1, 0],
    up: "+Y",
    metres: null,
    origin: [0, 0, 0],
    shape: [2, 4, 3],
    seconds_per_frame: 0.02,
    data: "",
    ...more,
  }) as Told;
const standing = Float32Array.of(0, 90, 0, 0, 40, 0, 0, 0, 0, 0, 170, 0);

describe("a preview", () => {
  it("draws straight lines between the frames that it has, and stays at its ends", () => {
    const preview = new Preview(one, 9, 30, Float32Array.of(0, 0, 0, 4, 8, 0), 4);
    expect([...preview.frame(1)]).toEqual([1, 2, 0]);
    expect([...preview.frame(4)]).toEqual([4, 8, 0]);
    expect([...preview.frame(99)]).toEqual([4, 8, 0]);
    expect([...preview.frame(-1)]).toEqual([0, 0, 0]);
  });

  it("has every frame of a short motion, and fits long ones and many points into one answer", () => {
    expect(stepFor(300, 30)).toBe(1);
    expect(stepFor(8000, 1)).toBe(2);
    const step = stepFor(4000, 1000);
    expect((4000 / step) * 1000 * 12).toBeLessThanOrEqual(4 << 20);
  });

  it("reads positions of an answer", () => {
    const data = btoa(String.fromCharCode(...new Uint8Array(Float32Array.of(1.5, -2, 0).buffer)));
    expect([...numbersOf(told({ data }))]).toEqual([1.5, -2, 0]);
    expect([...previewOf(told({ data }), one, 1, 30, 1).frame(0)]).toEqual([1.5, -2, 0]);
  });
});

describe("a body of a preview alone", () => {
  it("has sides and a head by names, edges by parents, and a person's height where the unit is unknown", () => {
    const body = bodyOf(told(), standing, 2);
    expect([...body.sides]).toEqual([0, 1, 2, 0].map((side, at) => (at === 1 ? 0 : side)));
    expect([...body.edges]).toEqual([0, 1, 1, 2, 0, 3]);
    expect(body.head).toBe(3);
    expect(body.metres * 170).toBeCloseTo(1.7);
    expect([body.unitKnown, body.height]).toEqual([false, 1.7]);
  });

  it("keeps a unit that is known, and stands up along Z", () => {
    const lying = bodyOf(told({ up: "+Z", metres: 0.01 }), standing, 2);
    expect([lying.zUp, lying.metres, lying.unitKnown]).toEqual([true, 0.01, true]);
    // Nothing is above anything: a usual height, so that cameras have something to see.
    expect(lying.height).toBe(1.7);
  });

  it("plays as a whole at its own rate", () => {
    const whole = wholeOf(told(), standing);
    expect([whole.frames, whole.perSecond]).toEqual([2, 50]);
    expect(wholeOf(told({ seconds_per_frame: null }), standing).perSecond).toBe(30);
  });
});
