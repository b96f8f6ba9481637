import { describe, expect, it } from "vitest";
import { numberAt } from "../../lists";
import { random } from "../../testing/random";
import { curvesOfBone, keyOf, nameOf, pointsOf, replacedRanges, startCurve } from "./comparing";

const bone = (name: string, ...channels: string[]) => ({ name, channels }) as Parameters<typeof curvesOfBone>[0];
const skeleton = [bone("Root", "Tx", "Ty", "Rz"), bone("tail"), bone("C7", "Tx", "Ty")];

describe("points of a reduced curve", () => {
  it("are the samples where every frame is there", () => {
    const values = [1, null, 3];
    expect(pointsOf({ first: 5, step: 1, minimum: values, maximum: values })).toEqual({ frames: [5, 6, 7], values });
  });
  it("are both extremes of each range, in rising frames inside the ranges", () => {
    const draw = random(7);
    for (let round = 0; round < 200; round++) {
      const pairs = Array.from({ length: draw.whole(1, 40) }, () => [draw(), 1 + draw()]);
      const [step, first, shift] = [draw.whole(2, 600), draw.whole(1, 900), draw.whole(0, 90)];
      const [minimum, maximum] = [0, 1].map((end) => pairs.map((pair) => numberAt(pair, end)));
      const { frames, values } = pointsOf({ first, step, minimum: minimum!, maximum: maximum! }, shift);
      expect(values).toEqual(pairs.flat());
      const ranges = frames.map((frame) => Math.floor((frame - first - shift) / step));
      expect(ranges).toEqual(frames.map((_, at) => Math.floor(at / 2)));
      expect(new Set(frames).size).toBe(2 * pairs.length);
      expect([...frames].sort((a, b) => a - b)).toEqual(frames);
    }
  });
});

describe("the curves that can be chosen", () => {
  it("keep their names as keys", () => {
    const kinds = ["column", "quantity"] as const;
    for (const kind of kinds)
      for (const name of ["Root.Tx", "a=b.Tx", "speed:right_hand,Root", ""])
        expect(nameOf(keyOf({ kind, name }))).toEqual({ kind, name });
  });
  it("are channels, then quantities whose arguments can be told apart", () => {
    expect(curvesOfBone(bone("C7", "Tx")).map(keyOf)).toEqual([
      "column=C7.Tx",
      "quantity=height:C7",
      "quantity=speed:C7",
    ]);
    expect(curvesOfBone(bone("a,b", "Tx")).map(keyOf)).toEqual(["column=a,b.Tx"]);
  });
  it("begin with a rotation of a wanted joint, else with the first channel", () => {
    expect(startCurve(skeleton, [])?.name).toBe("Root.Tx");
    expect(startCurve(skeleton, ["Root"])?.name).toBe("Root.Rz");
    expect(startCurve(skeleton, ["nobody", "tail", "C7"])?.name).toBe("C7.Tx");
    expect(startCurve([bone("tail")], ["tail"])).toBeNull();
  });
  it("have the frames in which their marker has new samples", () => {
    const ranges = [{ first: 3, last: 5 }];
    const replaced = [{ bone: "S1.C7", channels: ["Tx"], frames: 3, ranges }];
    expect(replacedRanges(replaced, { kind: "column", name: "S1.C7.Ty" })).toBe(ranges);
    expect(replacedRanges(replaced, { kind: "column", name: "S1.Ty" })).toEqual([]);
    expect(replacedRanges(replaced, { kind: "quantity", name: "height:S1.C7" })).toEqual([]);
  });
});
