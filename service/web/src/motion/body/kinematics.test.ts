import { describe, expect, it } from "vitest";
import { columnsOf, posed } from "./kinematics";
import { skeletonOf, type SkeletonView } from "./skeleton";

type Bone = SkeletonView["bones"][number];
const bone = (name: string, parent: number, more: Partial<Bone>): Bone =>
  ({
    name,
    parent,
    side: "centre",
    partner: -1,
    offset: [0, 0, 0],
    axes: [0, 0, 0, 1],
    along: [0, 1, 0],
    channels: [],
    rotation_order: "xyz",
    convention: "listed",
    translation: "",
    ...more,
  }) as Bone;

/** A root that moves, a joint 2 above it that turns, a tip 1 above that. */
function pose(values: number[], elbow: Partial<Bone> = {}, root: Partial<Bone> = {}, origin = [0, 0, 0]): number[][] {
  const view = {
    bones: [
      bone("Root", -1, { channels: ["Tx", "Ty", "Tz", "Rz"], ...root }),
      bone("Elbow", 0, { offset: [0, 2, 0], channels: ["Rz"], ...elbow }),
    ],
    tips: [{ bone: 1, offset: [0, 1, 0] }],
    centres: [],
    lines: [],
    columns: ["Root.Tx", "Root.Ty", "Root.Tz", "Root.Rz", "Elbow.Rz", "Elbow.SF"],
    likely_up: "+Y",
    radians: Math.PI / 180,
    origin,
  } as unknown as SkeletonView;
  const found = [...posed(skeletonOf(view), columnsOf(view), values)];
  return [0, 3, 6].map((at) =>
    found.slice(at, at + 3).map((one) => (Number.isNaN(one) ? NaN : Math.round(one * 1e4) / 1e4 + 0)),
  );
}

describe("a pose of channels", () => {
  it("moves with its root and turns below each joint", () => {
    expect(pose([1, 2, 3, 0, 90, NaN])).toEqual([
      [1, 2, 3],
      [1, 4, 3],
      [0, 4, 3],
    ]);
    expect(pose([0, 0, 0, 90, 0, NaN])).toEqual([
      [0, 0, 0],
      [-2, 0, 0],
      [-3, 0, 0],
    ]);
    expect(pose([0, 0, 0, 90, 90, NaN])).toEqual([
      [0, 0, 0],
      [-2, 0, 0],
      [-2, -1, 0],
    ]);
  });

  it("is told from the origin of the clip", () => {
    expect(pose([5, 0, 0, 0, 0, NaN], {}, {}, [5, 1, 0])[0]).toEqual([0, -1, 0]);
  });

  it("hides what hangs on a missing sample, and nothing above it", () => {
    const [root, elbow, tip] = pose([1, 2, 3, 0, NaN, NaN]);
    expect([root, elbow, tip]).toEqual([
      [1, 2, 3],
      [NaN, NaN, NaN],
      [NaN, NaN, NaN],
    ]);
    expect(pose([NaN, 2, 3, 0, 0, NaN]).flat().every(Number.isNaN)).toBe(true);
  });

  it("adds positions to the rest where they are relative, and replaces it where they are listed", () => {
    const moved = { channels: ["Tx", "Ty", "Tz", "Rz"], offset: [0, 7, 0] };
    expect(pose([1, 2, 3, 0, 0, NaN], {}, { ...moved, translation: "relative" })[0]).toEqual([1, 9, 3]);
    expect(pose([1, 2, 3, 0, 0, NaN], {}, moved)[0]).toEqual([1, 2, 3]);
  });

  it("turns about the axes of a joint of ASF or HTR", () => {
    const half = Math.SQRT1_2;
    // Axes that are turned by 90 degrees about y: a turn about their z is one about x.
    const found = pose([0, 0, 0, 0, 90, NaN], { convention: "base", axes: [0, half, 0, half] });
    expect(found[2]).toEqual([0, 2, 1]);
  });

  it("scales what hangs on a joint", () => {
    const scaled = { channels: ["Rz", "SF"] };
    expect(pose([0, 0, 0, 0, 0, 3], scaled)[2]).toEqual([0, 5, 0]);
    expect(pose([0, 0, 0, 0, 0, 1], { ...scaled, convention: "fixed", along: [0, 2, 0] })[2]).toEqual([0, 3.5, 0]);
  });
});
