import { describe, expect, it } from "vitest";
import { Player } from "../../state/clip/player";
import { densityOf, hullOf, onStep, samePhase, stepOver } from "./phases";

describe("phases", () => {
  it("finds the same phase in a longer motion", () => {
    const [from, to] = [
      [0, 10, 30, 70],
      [0, 5, 45, 100],
    ] as const;
    expect(samePhase(0, from, to)).toBe(0);
    expect(samePhase(5, from, to)).toBe(2.5);
    expect(samePhase(20, from, to)).toBe(25);
    expect(samePhase(70, from, to)).toBe(100);
    expect(samePhase(80, from, to)).toBe(100);
  });

  it("goes there and back to where it was", () => {
    const [from, to] = [
      [0, 7.7, 28.3, 66],
      [0, 9.1, 33.2, 71.4],
    ] as const;
    for (const frame of [0.3, 7.7, 15, 28.3, 50, 65.9])
      expect(samePhase(samePhase(frame, from, to), to, from)).toBeCloseTo(frame, 9);
  });

  it("keeps fractions when a player goes on in another motion", () => {
    const player = new Player(60, 30);
    player.seek(12.75);
    player.become(80, 30, 15.5);
    expect([player.frames, player.at, player.frame.value]).toEqual([80, 15.5, 15]);
    player.become(10, 60, 15.5);
    expect([player.frames, player.perSecond, player.at]).toEqual([10, 60, 9]);
  });
});

describe("attributes", () => {
  it("steps by round numbers", () => {
    expect([59, 25, 227, 100, 0].map(stepOver)).toEqual([0.5, 0.2, 2, 1, 1]);
    expect(onStep(47.26, 0.2)).toBe(47.2);
  });

  it("puts a hull round points", () => {
    const hull = hullOf([
      [0, 0],
      [2, 0],
      [1, 1],
      [2, 2],
      [0, 2],
      [1, 0.5],
    ]);
    expect(hull).toEqual([
      [0, 0],
      [2, 0],
      [2, 2],
      [0, 2],
    ]);
    expect(
      hullOf([
        [1, 1],
        [0, 0],
      ]),
    ).toEqual([
      [0, 0],
      [1, 1],
    ]);
  });

  it("sees a gap in a density", () => {
    const density = densityOf([20, 21, 22, 22, 60, 61], 20, 61, 41);
    expect(Math.max(...density)).toBe(1);
    expect(density[20]).toBeLessThan(0.001);
  });
});
