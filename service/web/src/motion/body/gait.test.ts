import { expect, test } from "vitest";
import { bandOf, csvOf, pairsOf } from "./gait";

const named = (name: string) => ({ function: "quantity", name, axes: ["x", "y", "z"], unit: "deg", reason: "" });

test("angles of the laboratory's own model come first, with both sides", () => {
  const measured = ["Anna:LKneeAngles", "Anna:RKneeAngles", "Anna:LHipAngles", "LKneeForce"].map(named);
  expect(pairsOf(measured, "y", true)).toEqual([
    { title: "Knee", left: "quantity:Anna:LKneeAngles,y", right: "quantity:Anna:RKneeAngles,y" },
  ]);
  expect(pairsOf([], "x", true)).toEqual([]);
  expect(pairsOf([], "x", false).map((pair) => pair.left)).toContain("angle:left-knee-flexion");
});

test("a missing standard deviation has no band", () => {
  const cycle = { quantity: "a", side: "left" as const, unit: "deg", mean: [1, 2, null], sd: [0.5, null, 1] };
  expect(bandOf(cycle, 1)).toEqual([1.5, null, null]);
  expect(bandOf(cycle, -1)).toEqual([0.5, null, null]);
});

test("parameters and cycles leave in long form", () => {
  const parameter = {
    name: "speed",
    unit: "m/s",
    left: { mean: 1.25, sd: null, n: 1 },
    right: { mean: null, sd: null, n: 0 },
    symmetry: null,
  };
  const cycle = { quantity: "quantity:=K,x", side: "right" as const, unit: "deg", mean: [7.5], sd: [null] };
  expect(csvOf([parameter], [cycle]).split("\r\n")).toEqual([
    "name,side,percent,mean,sd,n,unit",
    "speed,left,,1.25,,1,m/s",
    "speed,right,,,,0,m/s",
    '"quantity:=K,x",right,0,7.5,,,deg',
    "",
  ]);
});
