import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import type { Schemas } from "../../api/client";
import { itemAt, numberAt } from "../../lists";
import { leadersOf, moveSkin, skinOf, type Skin } from "./skin";

const HALF = Math.SQRT1_2;
/** Two joints, one 2 above the other, far from the origin; the upper one is bound turned by 90 degrees about Z. */
const MESH: Schemas["CharacterMesh"] = {
  points: [1000, 1, 0, 1000, 3, 0, 1000, 2, 1],
  triangles: [0, 1, 2],
  joints: [0, 0, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0],
  weights: [1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0],
  bind_positions: [
    [1000, 0, 0],
    [1000, 2, 0],
  ],
  bind_rotations: [
    [0, 0, 0, 1],
    [0, 0, HALF, HALF],
  ],
};
const STILL = [0, 0, 0, 1];

/** Where vertices are, as shaders compute it. */
function moved(skin: Skin, positions: number[], turns: number[], metres: number): number[][] | null {
  const into = new Float32Array(skin.turns.length * 16);
  if (!moveSkin(skin, positions, turns, metres, into)) return null;
  return Array.from({ length: skin.points.length / 3 }, (_, vertex) => {
    const at = [0, 0, 0];
    for (let slot = 0; slot < 4; slot++) {
      const weight = numberAt(skin.weights, vertex * 4 + slot);
      const joint = numberAt(skin.joints, vertex * 4 + slot) * 16;
      if (!weight) continue;
      for (let axis = 0; axis < 3; axis++) {
        let sum = numberAt(into, joint + 12 + axis);
        for (let part = 0; part < 3; part++)
          sum += numberAt(into, joint + part * 4 + axis) * numberAt(skin.points, vertex * 3 + part);
        at[axis] = numberAt(at, axis) + weight * sum;
      }
    }
    return at;
  });
}

describe("a mesh that follows joints", () => {
  it("is where it was bound, in metres, wherever the body is", () => {
    const skin = skinOf(MESH);
    const found = moved(skin, [5, 0, 0, 5, 2, 0], [...STILL, 0, 0, HALF, HALF], 0.01)!;
    [
      [0.05, 0.01, 0],
      [0.05, 0.03, 0],
      [0.05, 0.02, 0.01],
    ].forEach((point, vertex) =>
      point.forEach((value, axis) => expect(itemAt(found, vertex)[axis]).toBeCloseTo(value, 6)),
    );
  });

  it("turns with its joints from the pose that it is bound in", () => {
    const found = moved(skinOf(MESH), [0, 0, 0, 0, 2, 0], [...STILL, ...STILL], 1)!;
    // The upper joint has turned back by 90 degrees: what was above it is to its right.
    itemAt(found, 1).forEach((value, axis) => expect(value).toBeCloseTo(itemAt([1, 2, 0], axis), 5));
  });

  it("is not shown where a joint that it needs is unknown, and others do not matter", () => {
    const skin = skinOf(MESH);
    expect(moved(skin, [NaN, 0, 0, 0, 2, 0], [...STILL, ...STILL], 1)).toBeNull();
    expect(moved(skin, [0, 0, 0, 0, 2, 0], [...STILL, NaN, 0, 0, 1], 1)).toBeNull();
    const alone = skinOf({ ...MESH, joints: MESH.joints.map(() => 0) });
    expect(moved(alone, [0, 0, 0, NaN, 2, 0], [...STILL, ...STILL], 1)).not.toBeNull();
  });

  it("has a first joint for each vertex", () => {
    expect([...leadersOf(skinOf(MESH))]).toEqual([0, 1, 1]);
  });
});

interface Case {
  title: string;
  mesh: Schemas["CharacterMesh"];
  frames: { positions: number[]; turns: number[]; expected: number[][] }[];
  size: number;
}
// Figures and their vertices in some frames, as the tests in Python have written them.
const { MCML_FIGURES } = process.env;
const cases: Case[] = MCML_FIGURES ? (JSON.parse(readFileSync(MCML_FIGURES, "utf8")) as Case[]) : [];

describe.skipIf(!cases.length)("the figure of a clip", () => {
  it.each(cases.map((one) => [one.title, one] as const))("%s: is where Python moves it", (_, one) => {
    const skin = skinOf(one.mesh);
    for (const { positions, turns, expected } of one.frames) {
      const found = moved(skin, positions, turns, 1)!;
      let worst = 0;
      found.forEach((point, vertex) => {
        const wanted = itemAt(expected, vertex);
        worst = Math.max(worst, Math.hypot(...point.map((value, axis) => value - numberAt(wanted, axis))));
      });
      expect(worst / one.size).toBeLessThan(2e-4);
    }
  });
});
