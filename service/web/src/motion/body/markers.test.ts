import { describe, expect, it } from "vitest";
import { skeletonOf, type SkeletonView } from "./skeleton";

describe("markers of a person", () => {
  it("are connected by the lines that the server tells", () => {
    const bone = (name: string) => ({ name, parent: -1, side: "centre", offset: [0, 0, 0], convention: "marker" });
    const markers = { bones: ["LASI", "LKNE", "LANK"].map(bone), tips: [], markers: true, likely_up: "Z" };
    const told = {
      ...markers,
      metres: 0.001,
      lines: [
        [0, 1],
        [1, 2],
      ],
    } as unknown as SkeletonView;
    const skeleton = skeletonOf(told);
    expect([...skeleton.edges]).toEqual([0, 1, 1, 2]);
    expect([...skeleton.parents]).toEqual([-1, -1, -1]);
  });

  it("are points where an earlier release answered", () => {
    const bone = { name: "LASI", parent: -1, side: "centre", offset: [0, 0, 0], convention: "marker" };
    const kept = { bones: [bone], tips: [], markers: true, likely_up: "Z", metres: 1 } as unknown as SkeletonView;
    const { edges, view } = skeletonOf(kept);
    expect([edges.length, view.plates, view.centres]).toEqual([0, [], []]);
  });
});
