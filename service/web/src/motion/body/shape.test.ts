import { itemAt, numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { about, multiply, type Vector } from "./quaternions";
import { reshaped, restOf, textsOf, vectorOf } from "./shape";
import { skeletonOf, type Skeleton, type SkeletonView } from "./skeleton";

const NAMES = ["Root", "left_leg", "left_foot", "left_toe"];

/** A chain of bones of one convention. */
function chain(convention: "listed" | "base" | "fixed" | "marker", seed = 1): Skeleton {
  const draw = random(seed);
  const any = (): Vector => [draw() * 9 + 1, draw() * 9 - 20, draw() * 9];
  let above = any();
  const bones = NAMES.map((name, index) => {
    const along = any();
    const bone = {
      address: `/mcml/skeleton${"/bone".repeat(index + 1)}`,
      name,
      source_name: name,
      parent: index - 1,
      side: "centre",
      partner: index,
      offset: convention === "fixed" ? above : any(),
      axes: multiply(about("X", draw()), about("Z", draw())),
      along: convention === "listed" ? [0, 0, 0] : along,
      channels: ["Rx"],
      rotation_order: "XYZ",
      convention,
      translation: "",
    };
    above = along;
    return bone;
  });
  const tips = [{ bone: 3, name: "", offset: convention === "fixed" ? itemAt(bones, 3).along : any() }];
  return skeletonOf({
    bones,
    tips,
    lines: [],
    metres: 0.01,
    unit: "cm",
    origin: [0, 0, 0],
    likely_up: "Y",
    markers: false,
    frames: 1,
    columns: [],
  } as unknown as SkeletonView);
}

const changesOf = (skeleton: Skeleton, bone: number, vector: Vector) =>
  new Map(
    textsOf(skeleton.view, bone, vector).map(({ address, text }) => [address, { address, attributes: {}, text }]),
  );
const near = (a: readonly number[], b: readonly number[]) =>
  a.forEach((one, axis) => expect(one).toBeCloseTo(numberAt(b, axis), 3));

describe("bones at rest that are changed and not stored", () => {
  it.each(["listed", "base", "fixed"] as const)(
    "%s: the texts that are written say the vector that was wanted",
    (convention) => {
      for (let seed = 1; seed < 30; seed++) {
        const skeleton = chain(convention, seed);
        for (let bone = 1; bone < NAMES.length; bone++) {
          const wanted: Vector = [seed, -3.25, bone];
          const found = reshaped(skeleton, changesOf(skeleton, bone, wanted));
          near(vectorOf(found.view, bone)!, wanted);
          for (let other = 1; other < NAMES.length; other++)
            if (other !== bone) expect(vectorOf(found.view, other)).toEqual(vectorOf(skeleton.view, other));
        }
      }
    },
  );

  it("carry along what hangs on them, and nothing else", () => {
    const skeleton = chain("listed");
    const before = restOf(skeleton);
    const offset = vectorOf(skeleton.view, 2)!;
    const after = restOf(reshaped(skeleton, changesOf(skeleton, 2, [offset[0] + 5, offset[1], offset[2]])));
    const moved = [...after].map((value, at) => Math.round((value - numberAt(before, at)) * 1000) / 1000);
    expect(moved).toEqual([0, 0, 0, 0, 0, 0, 5, 0, 0, 5, 0, 0, 5, 0, 0]);
  });

  it("of ASF move the joints at the bone's end, and its tip", () => {
    const skeleton = chain("fixed");
    const found = reshaped(skeleton, changesOf(skeleton, 3, [0, -7, 0]));
    near(itemAt(found.view.tips, 0).offset, [0, -7, 0]);
    near(itemAt(reshaped(skeleton, changesOf(skeleton, 1, [0, -7, 0])).view.bones, 2).offset, [0, -7, 0]);
    const scaled = reshaped(skeleton, new Map([[`${itemAt(skeleton.view.bones, 1).address}/length`, { text: "2" }]]));
    expect(Math.hypot(...itemAt(scaled.view.bones, 1).along)).toBeCloseTo(2);
  });

  it("are the stored ones where no draft says otherwise, or says no numbers", () => {
    const skeleton = chain("listed");
    expect(reshaped(skeleton, new Map())).toBe(skeleton);
    for (const text of ["", "1 2", "1 2 x", undefined])
      expect(reshaped(skeleton, new Map([[`${itemAt(skeleton.view.bones, 1).address}/position`, { text }]]))).toBe(
        skeleton,
      );
    expect(vectorOf(skeleton.view, 0)).toBeNull();
    expect(vectorOf(chain("marker").view, 1)).toBeNull();
  });
});
