import { describe, expect, it } from "vitest";
import { editOf, framesAt, seenFrames, START } from "./edits";

describe("edits of frames", () => {
  it("sends one factor while all are the same", () => {
    const [same] = editOf("speed", { ...START, factors: [2, 2, 2] }, [], [1, 100]);
    expect(same).toEqual({ do: "speed", first: 1, last: 100, factors: [2] });
    const [curve] = editOf("speed", { ...START, factors: [1, 0.5, 1] }, [], [1, 100]);
    expect(curve).toMatchObject({ factors: [1, 0.5, 1] });
  });

  it("limits repairs to the selected joints only where that is chosen", () => {
    expect(editOf("fill", { ...START, selected: true }, ["Root"], [1, 9])).toMatchObject([{ bones: ["Root"] }]);
    expect(editOf("fill", START, ["Root"], [1, 9])).toMatchObject([{ bones: [] }]);
    expect(editOf("mirror", { ...START, selected: true }, ["Root"], [1, 9])).toEqual([
      { do: "mirror", first: 1, last: 9 },
    ]);
  });

  it("counts frames at other speeds as the integral of the pace", () => {
    expect(framesAt(100, [2])).toBe(50);
    expect(framesAt(100, [1, 1, 1])).toBe(100);
    const steps = 100_000;
    let time = 0;
    for (let at = 0; at < steps; at++) time += 100 / steps / (0.5 + (1.5 * (at + 0.5)) / steps);
    expect(framesAt(100, [0.5, 2])).toBe(Math.round(time));
    expect(seenFrames("speed", { ...START, factors: [2, 2, 2] }, [11, 30])).toEqual({ first: 11, last: 20 });
    expect(seenFrames("loop", START, [11, 30])).toEqual({ first: 1 });
  });
});
