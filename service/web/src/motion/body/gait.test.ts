import { expect, test } from "vitest";
import { bandOf, hasBothModels, howComputed, meanOf, pairsOf } from "./gait";

const named = (name: string) => ({ function: "quantity", name, axes: ["x", "y", "z"], unit: "deg", reason: "" });

test("angles of the laboratory's own model come first, with both sides", () => {
  const measured = ["Anna:LKneeAngles", "Anna:RKneeAngles", "Anna:LHipAngles", "LKneeForce"].map(named);
  expect(pairsOf(measured, "y", true, "stated")).toEqual([
    { title: "Knee", left: "quantity:Anna:LKneeAngles,y", right: "quantity:Anna:RKneeAngles,y" },
  ]);
  expect(pairsOf([], "x", true, "stated")).toEqual([]);
  expect(pairsOf([], "x", false, "stated").map((pair) => pair.left)).toContain("angle:left-knee-flexion");
});

test("computed angles are shown beside those of the laboratory where they are asked for", () => {
  const own = ["LKneeAngles", "RKneeAngles", "LHipAngles", "RHipAngles"];
  const both = [...own, "cgm1:LKneeAngles", "cgm1:RKneeAngles"].map(named);
  expect(hasBothModels(both)).toBe(true);
  expect(hasBothModels(own.map(named))).toBe(false);
  const left = (model: "stated" | "computed") => pairsOf(both, "x", true, model).map((pair) => pair.left);
  expect(left("stated")).toEqual(["quantity:LHipAngles,x", "quantity:LKneeAngles,x"]);
  expect(left("computed")).toEqual(["quantity:LHipAngles,x", "quantity:cgm1:LKneeAngles,x"]);
});

test("quantities that cannot be computed are no curves, and computed ones say how", () => {
  const known = ["LHipAngles", "RHipAngles"].map((name) => ({ ...named(name), notes: ["computed by a model"] }));
  const unknown = ["LKneeAngles", "RKneeAngles"].map((name) => ({ ...named(name), reason: "missing: LKneeWidth" }));
  const pairs = pairsOf([...known, ...unknown], "x", true, "stated");
  expect(pairs.map((pair) => pair.title)).toEqual(["Hip"]);
  expect(howComputed(known, pairs)).toBe("computed by a model");
  expect(howComputed([{ ...named("LHipAngles"), notes: ["as computed by the laboratory"] }], pairs)).toBe("");
});

test("a missing standard deviation has no band", () => {
  const cycle = { quantity: "a", side: "left" as const, unit: "deg", mean: [1, 2, null], sd: [0.5, null, 1] };
  expect(bandOf(cycle, 1)).toEqual([1.5, null, null]);
  expect(bandOf(cycle, -1)).toEqual([0.5, null, null]);
});

test("a normal band is the mean of both sides, unknown where one is", () => {
  const [left, right] = (["left", "right"] as const).map((side, at) => ({
    quantity: side,
    side,
    unit: "deg",
    n: 2 + at,
    mean: [1 + 2 * at, at ? null : 4],
    sd: [0.5, 1.5],
  }));
  expect(meanOf([left!, right!])).toMatchObject({ n: 5, mean: [2, null], sd: [0.5, 1.5] });
  expect(meanOf([left!]).mean).toEqual([1, 4]);
});
