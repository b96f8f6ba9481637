import { describe, expect, it } from "vitest";
import { skeletonOf, type SkeletonView } from "./skeleton";

const body = (length: number): SkeletonView => {
  const bone = (name: string, parent: number, up: number) => ({
    name,
    parent,
    side: "centre",
    offset: [0, up, 0],
    convention: "base",
  });
  const bones = [bone("Root", -1, 0), bone("waist", 0, length), bone("Head", 1, length)];
  return { bones, tips: [], markers: false, likely_up: "Y", metres: 0.01 } as unknown as SkeletonView;
};

describe("the height of a skeleton", () => {
  it("is that of its rest pose, in metres", () => {
    expect(skeletonOf(body(80)).height).toBeCloseTo(1.6);
    expect(skeletonOf(body(3)).height).toBe(0.1);
  });

  it("is at most that of a giant, unless the whole body is far larger", () => {
    expect(skeletonOf(body(300)).height).toBe(3);
    expect(skeletonOf(body(7700)).height).toBeCloseTo(154);
  });

  it("is the usual one where the rest pose has no lengths, so that bones are drawn as thick as others", () => {
    expect(skeletonOf(body(0)).height).toBe(1.7);
  });
});

describe("the lines of a skeleton", () => {
  it("lead to no targets of inverse kinematics", () => {
    const plain = body(80);
    const target = { ...plain.bones[0], name: "ik_hand_root", parent: 0, role: "control" };
    const hand = { ...plain.bones[0], name: "ik_hand_l", parent: 3, role: "control" };
    const { edges } = skeletonOf({ ...plain, bones: [...plain.bones, target, hand] } as SkeletonView);
    expect([...edges]).toEqual([0, 1, 1, 2]);
  });
});
