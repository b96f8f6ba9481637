import { describe, expect, it } from "vitest";
import { angleOf, drawingIn, lengthOf, movePoint, offsetOf, type Point } from "./drawing";

describe("drawings on a video", () => {
  it("measures angles that do not depend on place, size, turn or order", () => {
    for (const degrees of [0, 1, 30, 90, 135, 179.5, 180])
      for (const turn of [0, 0.7, 2, 4])
        for (const sign of [1, -1]) {
          const way = (angle: number, size: number): Point => [
            100 + size * Math.cos(turn + angle),
            50 + size * Math.sin(turn + angle),
          ];
          const points = [way(0, 20), [100, 50] as const, way((sign * degrees * Math.PI) / 180, 7)];
          expect(angleOf(points)).toBeCloseTo(degrees, 6);
          expect(angleOf([...points].reverse())).toBeCloseTo(degrees, 6);
        }
  });
  it("has no angle where an end lies on the corner", () => {
    expect(
      angleOf([
        [3, 4],
        [3, 4],
        [8, 1],
      ]),
    ).toBeNaN();
  });
  it("measures lengths in pixels", () => {
    expect(
      lengthOf([
        [1, 1],
        [4, 5],
      ]),
    ).toBe(5);
  });
  it("begins inside the picture, and keeps points there", () => {
    for (const kind of ["angle", "length"] as const) {
      const one = drawingIn(kind, 1, 640, 360, 2);
      for (const [x, y] of one.points) expect(x > 0 && x < 640 && y > 0 && y < 360).toBe(true);
      expect(movePoint(one, 0, [-5, 999], 640, 360).points[0]).toEqual([0, 360]);
      expect(movePoint(one, 0, [1, 2], 640, 360).points.slice(1)).toEqual(one.points.slice(1));
    }
    expect(angleOf(drawingIn("angle", 1, 640, 360, 0).points)).toBeCloseTo(90);
  });
  it("finds the offset by which a moment and a frame are the same", () => {
    expect(offsetOf(3.5, 120, 60)).toBe(1.5);
    expect(offsetOf(0.5, 120, 60)).toBe(-1.5);
  });
});
