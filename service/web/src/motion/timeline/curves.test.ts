import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { scaled, shifted, smoothed, unwrapped } from "./curves";

const curve = (seed: number, gaps: boolean): number[] => {
  const draw = random(seed);
  let value = 0;
  return Array.from({ length: draw.whole(1, 60) }, () =>
    gaps && draw() < 0.15 ? NaN : (value += (draw() - 0.5) * 300),
  );
};
const there = (values: ArrayLike<number>) => Array.from(values).filter((one) => !Number.isNaN(one));

describe("unwrapped angles", () => {
  it("differ from the angles by whole turns, and never jump by more than half a one", () => {
    for (let seed = 0; seed < 100; seed++) {
      const before = curve(seed, true).map((one) => ((one + 180) % 360) - 180);
      const after = unwrapped(before);
      expect(there(after).length).toBe(there(before).length);
      there(after).forEach((one, index, all) => {
        if (index) expect(Math.abs(one - numberAt(all, index - 1))).toBeLessThanOrEqual(180 + 1e-9);
        const turns = (one - numberAt(there(before), index)) / 360;
        expect(turns).toBeCloseTo(Math.round(turns), 9);
      });
    }
  });

  it("are the curve that was wrapped", () => {
    const draw = random(7);
    let value = 0;
    const whole = Array.from({ length: 400 }, () => (value += (draw() - 0.45) * 300));
    const wrapped = whole.map((one) => one - 360 * Math.round(one / 360));
    const turns = numberAt(whole, 0) - numberAt(wrapped, 0);
    unwrapped(wrapped).forEach((one, index) => expect(one + turns).toBeCloseTo(numberAt(whole, index), 6));
    const radians = unwrapped(
      wrapped.map((one) => (one * Math.PI) / 180),
      2 * Math.PI,
    );
    radians.forEach((one, index) => expect((one * 180) / Math.PI + turns).toBeCloseTo(numberAt(whole, index), 6));
  });
});

describe("a smoothed stretch", () => {
  /** Every value as the mean of all others, by their distance. */
  const obvious = (values: number[], at: number, width: number): number => {
    let [sum, weight] = [0, 0];
    for (let other = at - 1000; other <= at + 1000; other++) {
      if (Math.abs(other - at) > Math.max(1, Math.ceil(3 * width))) continue;
      const value = numberAt(values, Math.min(values.length - 1, Math.max(0, other)));
      if (Number.isNaN(value)) continue;
      const share = Math.exp(-((other - at) ** 2) / (2 * width ** 2));
      [sum, weight] = [sum + share * value, weight + share];
    }
    return sum / weight;
  };

  it("is a Gaussian in its middle and the old curve at its ends", () => {
    for (let seed = 0; seed < 60; seed++) {
      const [values, width] = [curve(seed, true), 0.5 + (seed % 6)];
      const found = smoothed(values, width);
      const [fade, last] = [Math.ceil(width), values.length - 1];
      values.forEach((value, at) => {
        if (Number.isNaN(value)) {
          expect(found[at]).toBeNaN();
          return;
        }
        if (at === 0 || at === last) {
          last > 1 && expect(found[at]).toBe(value);
          return;
        }
        if (Math.min(at, last - at) >= fade) expect(found[at]).toBeCloseTo(obvious(values, at, width), 9);
        else {
          const [low, high] = [value, obvious(values, at, width)].sort((a, b) => a - b);
          expect(found[at]).toBeGreaterThanOrEqual(low! - 1e-9);
          expect(found[at]).toBeLessThanOrEqual(high! + 1e-9);
        }
      });
    }
  });

  it("leaves what is even as it is", () => {
    for (const found of [smoothed([4, 4, 4, 4, 4], 2), smoothed([4], 3)])
      found.forEach((one) => expect(one).toBeCloseTo(4, 12));
    expect([...smoothed([], 2)]).toEqual([]);
  });
});

describe("scaling and shifting", () => {
  it("keep the mean, or move it", () => {
    for (let seed = 0; seed < 60; seed++) {
      const values = curve(seed, true);
      const mean = there(values).reduce((sum, one) => sum + one, 0) / there(values).length;
      scaled(values, 0.5).forEach((one, at) =>
        Number.isNaN(values[at])
          ? expect(one).toBeNaN()
          : expect(one - mean).toBeCloseTo((numberAt(values, at) - mean) / 2, 9),
      );
      shifted(values, 3).forEach((one, at) =>
        Number.isNaN(values[at]) ? expect(one).toBeNaN() : expect(one).toBe(numberAt(values, at) + 3),
      );
    }
    expect([...scaled([], 2)]).toEqual([]);
  });
});
