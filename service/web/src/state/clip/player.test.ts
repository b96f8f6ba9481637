// @vitest-environment happy-dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Player } from "./player";

let waiting: ((now: number) => void) | null = null;
let now = 0;
/** Let time pass and the next frame be drawn. */
function pass(ms: number): void {
  now += ms;
  const draw = waiting;
  waiting = null;
  draw?.(now);
}

beforeEach(() => {
  [waiting, now] = [null, 0];
  vi.stubGlobal("requestAnimationFrame", (draw: (now: number) => void) => {
    waiting = draw;
    return 1;
  });
  vi.stubGlobal("cancelAnimationFrame", () => (waiting = null));
  vi.spyOn(performance, "now").mockImplementation(() => now);
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

describe("a player", () => {
  it("goes on by the time that passed, not by frames drawn", () => {
    const player = new Player(100, 50);
    player.play();
    pass(100);
    expect(player.frame.value).toBe(5);
    pass(10);
    expect(player.at).toBeCloseTo(5.5);
    // A window that slept does not jump by all of the time that it slept.
    pass(60_000);
    expect(player.frame.value).toBe(18);
  });

  it("begins again at the end, and repeats only its loop", () => {
    const player = new Player(10, 10);
    player.seek(9);
    player.play();
    expect(player.frame.value).toBe(0);
    player.loop.value = [2, 4];
    player.seek(4);
    pass(200);
    expect(player.frame.value).toBe(3);
    expect(player.range).toEqual([2, 4]);
  });

  it("plays backwards into the end of its loop", () => {
    const player = new Player(10, 10);
    player.seek(1);
    player.play(-1);
    pass(150);
    expect(player.at).toBeCloseTo(9.5);
  });

  it("keeps to its frames, and stops where it is stepped", () => {
    const player = new Player(10, 10);
    player.play();
    player.step(-3);
    expect([player.frame.value, player.playing.value]).toEqual([0, false]);
    player.step(99);
    expect(player.frame.value).toBe(9);
    expect(waiting).toBeNull();
  });

  it("follows a clock that leads", () => {
    const player = new Player(100, 10);
    player.lead = () => 42.5;
    player.play();
    pass(1);
    expect(player.at).toBe(42.5);
  });

  it("shuttles twice as fast each time, at most eight times, and turns at natural speed", () => {
    const player = new Player(100, 10);
    const speeds = [1, 1, 1, 1, 1, -1, -1].map((way) => {
      player.shuttle(way as 1 | -1);
      return player.speed.value;
    });
    expect(speeds).toEqual([1, 2, 4, 8, 8, -1, -2]);
    player.toggle();
    expect(player.playing.value).toBe(false);
    player.toggle();
    expect([player.playing.value, player.speed.value]).toEqual([true, 2]);
  });

  it("does not play one frame, and goes on at a frame of another motion", () => {
    const player = new Player(1, 10);
    player.play();
    expect(player.playing.value).toBe(false);
    player.become(50, 25, 70);
    expect([player.frames, player.perSecond, player.frame.value]).toEqual([50, 25, 49]);
  });
});
