import { itemAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { lanes, moved, rulerStep, toFrame, toX, zoomed } from "./timeline";

describe("frames and pixels", () => {
  it("go both ways", () => {
    const draw = random(1);
    for (let round = 0; round < 200; round++) {
      const first = draw() * 1000;
      const range = { first, last: first + 1 + draw() * 5000 };
      const [frame, width] = [range.first + draw() * (range.last - range.first), 10 + draw() * 2000];
      expect(toFrame(toX(frame, range, width), range, width)).toBeCloseTo(frame, 6);
    }
    expect(toX(20, { first: 10, last: 30 }, 100)).toBe(50);
  });
});

describe("a ruler", () => {
  it("has the finest marks of 1, 2, 5 that are far enough apart", () => {
    const steps = [1, 2, 5]
      .flatMap((one) => [0, 1, 2, 3, 4, 5, 6].map((power) => one * 10 ** power))
      .sort((a, b) => a - b);
    const draw = random(2);
    for (let round = 0; round < 500; round++) {
      const range = { first: 0, last: 1 + draw() * 10 ** draw.whole(0, 5) };
      const [width, least] = [draw.whole(50, 2000), draw.whole(20, 90)];
      const obvious = steps.find((step) => (step * width) / range.last >= least);
      expect(rulerStep(range, width, least)).toBe(obvious);
    }
  });
});

describe("lanes", () => {
  it("let no span cover another, in as few lanes as spans that meet", () => {
    const draw = random(3);
    for (let round = 0; round < 200; round++) {
      const spans = Array.from({ length: draw.whole(0, 14) }, () => {
        const first = draw.whole(1, 40);
        return { first, last: first + draw.whole(0, 12) };
      });
      const found = lanes(spans);
      let most = 0;
      for (let frame = 1; frame <= 60; frame++) {
        const here = spans
          .map((_, index) => index)
          .filter((index) => itemAt(spans, index).first <= frame && frame <= itemAt(spans, index).last);
        most = Math.max(most, here.length);
        expect(new Set(here.map((index) => found[index])).size).toBe(here.length);
      }
      expect(Math.max(-1, ...found) + 1).toBe(most);
    }
  });
});

describe("zooming and moving", () => {
  it("stay in the clip, and about the frame where the clip allows it", () => {
    const draw = random(4);
    for (let round = 0; round < 500; round++) {
      const frames = draw.whole(1, 3000);
      let range = { first: 0, last: frames };
      for (let step = 0; step < 6; step++) {
        const about = range.first + draw() * (range.last - range.first);
        const at = toX(about, range, 1);
        range = zoomed(range, about, 0.3 + draw() * 2, frames);
        if (range.first > 1e-9 && range.last < frames - 1e-9) expect(toX(about, range, 1)).toBeCloseTo(at, 6);
        const size = range.last - range.first;
        range = moved(range, (draw() - 0.5) * frames, frames);
        expect(range.last - range.first).toBeCloseTo(size, 6);
        expect(range.first).toBeGreaterThanOrEqual(0);
        expect(range.last).toBeLessThanOrEqual(frames + 1e-6);
        expect(size).toBeGreaterThanOrEqual(Math.min(8, frames) - 1e-6);
      }
    }
  });
});
