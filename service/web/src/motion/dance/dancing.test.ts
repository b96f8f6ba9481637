import { itemAt, numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { AudioClock } from "./audioClock";
import { clicksBetween } from "./clicks";
import {
  accepted,
  movedBeat,
  nearestBeat,
  readAllowed,
  snapped,
  toggled,
  withBeat,
  withoutBeat,
  writeAllowed,
  type Beat,
} from "./dancing";
import { layOut } from "./layout";
import { peaksOf } from "./peaks";
import { tapped, tempoOf } from "./tempo";

describe("tapping", () => {
  const taps = (...times: number[]) => times.reduce<number[]>((all, time) => tapped(all, time), []);

  it("is the median of the last eight intervals", () => {
    expect(tempoOf(taps(0))).toBeNull();
    expect(tempoOf(taps(0, 500))).toBe(120);
    expect(tempoOf(taps(0, 500, 1000, 1500, 2400, 2900))).toBe(120);
    // Ten slow intervals, then eight quick ones: the slow ones are forgotten.
    const slow = Array.from({ length: 11 }, (_, at) => at * 1000);
    const quick = Array.from({ length: 8 }, (_, at) => 10_000 + (at + 1) * 400);
    expect(tempoOf(taps(...slow, ...quick))).toBe(150);
  });

  it("begins anew after a pause", () => {
    expect(tempoOf(taps(0, 500, 1000, 9000))).toBeNull();
    expect(tempoOf(taps(0, 500, 1000, 9000, 10_000))).toBe(60);
  });
});

describe("beats", () => {
  const beats: Beat[] = [
    { at: 0.5, kind: "detected" },
    { at: 1, kind: "tracked" },
    { at: 1.5, kind: "detected" },
  ];

  it("snap to the nearest minimum that is near enough", () => {
    expect(snapped(1.02, [0.5, 0.99, 1.06], 0.05)).toBe(0.99);
    expect(snapped(1.2, [0.5, 0.99, 1.06], 0.05)).toBe(1.2);
  });

  it("are added, moved and taken away, and stay in order", () => {
    expect(withBeat(beats, 0.7).map((one) => one.at)).toEqual([0.5, 0.7, 1, 1.5]);
    expect(withBeat(beats, 1.01)).toEqual([beats[0], { at: 1.01, kind: "hand" }, beats[2]]);
    expect(movedBeat(beats, 0, 1.2).map((one) => [one.at, one.kind])).toEqual([
      [1, "tracked"],
      [1.2, "hand"],
      [1.5, "detected"],
    ]);
    expect(withoutBeat(beats, 1)).toEqual([beats[0], beats[2]]);
    expect(itemAt(movedBeat(beats, 0, -3), 0).at).toBe(0);
    expect(beats).toHaveLength(3);
  });

  it("that were tracked are accepted", () => {
    expect(accepted(beats).map((one) => one.kind)).toEqual(["detected", "hand", "detected"]);
  });

  it("are found by where they are", () => {
    expect(nearestBeat(beats, 0.97, 0.1)).toBe(1);
    expect(nearestBeat(beats, 0.7, 0.1)).toBe(-1);
  });
});

describe("what may be danced where", () => {
  it("is written into an address and read again", () => {
    const allowed = toggled(toggled(toggled(new Map(), 5, 2), 4, 3), 4, 7);
    expect(writeAllowed(allowed)).toBe("4:3.7,5:2");
    expect(readAllowed("4:3.7,5:2")).toEqual(allowed);
    expect(writeAllowed(toggled(allowed, 5, 2))).toBe("4:3.7");
    expect(readAllowed("x:1,3,:4,0:1,2:a")).toEqual(new Map());
  });
});

describe("clicks", () => {
  const grid = Array.from({ length: 17 }, (_, at) => at * 0.5);

  it("are each scheduled once by windows that touch", () => {
    const all = [];
    for (let from = 0; from < 9; from += 0.1) all.push(...clicksBetween(grid, from, Math.min(9, from + 0.1)));
    expect(all.length).toBeGreaterThanOrEqual(17);
    expect(clicksBetween(grid, 0, 9)).toHaveLength(17);
    expect(clicksBetween(grid, 0, 2)).toEqual([
      { time: 0, first: true },
      { time: 0.5, first: false },
      { time: 1, first: false },
      { time: 1.5, first: false },
    ]);
    expect(clicksBetween(grid, 2, 2.4)).toEqual([{ time: 2, first: true }]);
    expect(clicksBetween(grid, 20, 30)).toEqual([]);
  });
});

describe("the clock of what is heard", () => {
  it("says nothing before anything was heard", () => {
    expect(new AudioClock().at(100, { contextTime: 0, performanceTime: 0 })).toBeNull();
  });

  it("runs on while readings repeat, and is smoother than they are", () => {
    const clock = new AudioClock();
    let worst = 0;
    let rough = 0;
    let seed = 1;
    const noise = () => ((seed = (seed * 16807) % 2147483647) / 2147483647 - 0.5) * 0.01;
    let reading = { contextTime: 0.001, performanceTime: 1001 };
    for (let frame = 0; frame < 3 * 60 * 60; frame++) {
      const now = 1001 + (frame * 1000) / 60;
      // A reading every other frame; the sound's own clock runs 50 millionths faster.
      if (frame % 2 === 0) {
        const off = frame ? noise() : 0;
        reading = { contextTime: 0.001 + ((now - 1001) / 1000) * 1.00005 + off, performanceTime: now };
        rough = Math.max(rough, Math.abs(off));
      }
      const truth = 0.001 + ((now - 1001) / 1000) * 1.00005;
      const off = Math.abs(clock.at(now, reading)! - truth);
      expect(off).toBeLessThan(0.005);
      if (frame > 60) worst = Math.max(worst, off);
    }
    expect(worst).toBeLessThan(rough / 2);
    expect(worst).toBeLessThan(1 / 240); // over three minutes
  });

  it("follows at once when the sound began elsewhere", () => {
    const clock = new AudioClock();
    clock.at(1000, { contextTime: 1, performanceTime: 1000 });
    expect(clock.at(1100, { contextTime: 5, performanceTime: 1100 })).toBeCloseTo(5, 9);
  });
});

describe("the layout of a graph", () => {
  it("keeps what is joined together, nobody in the same place, the same each time", () => {
    const links = [0, 5].flatMap((first) =>
      [0, 1, 2, 3, 4].flatMap((a) =>
        [0, 1, 2, 3, 4]
          .filter((b) => b > a)
          .map((b) => ({ from: first + a, to: first + b, distance: 0.02, natural: false })),
      ),
    );
    const places = layOut(10, links);
    expect(layOut(10, links)).toEqual(places);
    const away = (a: number, b: number) =>
      Math.hypot(
        numberAt(places, a * 2) - numberAt(places, b * 2),
        numberAt(places, a * 2 + 1) - numberAt(places, b * 2 + 1),
      );
    const mean = (values: number[]) => values.reduce((sum, one) => sum + one, 0) / values.length;
    const apart = [0, 1, 2, 3, 4].flatMap((a) => [5, 6, 7, 8, 9].map((b) => away(a, b)));
    expect(mean(links.map((one) => away(one.from, one.to)))).toBeLessThan(0.7 * mean(apart));
    for (let a = 0; a < 10; a++) for (let b = 0; b < a; b++) expect(away(a, b)).toBeGreaterThan(0.05);
    expect(Math.max(...places.map(Math.abs))).toBeLessThanOrEqual(1.7 + 1e-6);
  });

  it("is made of hundreds of bars", () => {
    const links = Array.from({ length: 1500 }, (_, at) => ({
      from: (at * 7) % 300,
      to: (at * 13 + 1) % 300,
      distance: (at % 10) / 100,
      natural: at % 30 === 0,
    }));
    const places = layOut(300, links);
    expect(places.every(Number.isFinite)).toBe(true);
    expect(layOut(300, links, places)).toHaveLength(600);
    expect(layOut(1, [])).toHaveLength(2);
    expect(layOut(0, [])).toHaveLength(0);
  });
});

describe("the outline of a sound", () => {
  it("has the least and most of each stretch", () => {
    expect([...peaksOf(Float32Array.from([0, 1, -1, 0.5, 0.25, -0.5]), 3)]).toEqual([0, 1, -1, 0.5, -0.5, 0.25]);
  });
});
