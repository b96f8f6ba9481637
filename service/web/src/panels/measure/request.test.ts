import { expect, test } from "vitest";
import { bothSides, GAIT, keyOf, readAsked, requestOf, writeQuantities } from "./request";

const asked = (text: string) => {
  const params = new URLSearchParams(text);
  return readAsked((name) => params.get(name) ?? "");
};

test("the address says what is measured", () => {
  const knee = "angle:left-knee-flexion|position:left_hand,up";
  const found = asked(`m=${encodeURIComponent(knee)}&ranges=label:big step&by=property:age`);
  expect(found.quantities).toEqual(["angle:left-knee-flexion", "position:left_hand,up"]);
  expect(writeQuantities(found.quantities)).toBe(knee);
  expect(requestOf({ project: "p" }, found)).toEqual({
    selection: { project: "p", documents: [], property: [], include_made: true },
    quantities: found.quantities,
    query: undefined,
    cycles: ["big step"],
    strides: false,
    by: ["side", "property:age"],
  });
  expect(writeQuantities([])).toBeNull();
});

test("nothing is asked before clips and measurements are chosen", () => {
  expect(requestOf(null, asked("m=time"))).toBeNull();
  expect(requestOf({ project: "p" }, asked(""))).toBeNull();
  expect(requestOf(null, asked("m=time&ranges=query&q=%20"))).toBeNull();
  expect(requestOf(null, asked("m=time&ranges=query&q=//frame"))?.query).toBe("//frame");
  expect(requestOf({ project: "p" }, asked("m=time&ranges=strides&q=//frame"))).toMatchObject({
    strides: true,
    cycles: [],
    query: undefined,
  });
});

test("a side has its other side", () => {
  expect(bothSides("angle:right-knee-flexion")).toEqual(["angle:left-knee-flexion", "angle:right-knee-flexion"]);
  expect(bothSides("speed:left_hand,Root")).toEqual(["speed:left_hand,Root", "speed:right_hand,Root"]);
  expect(bothSides("distance:left_hand,right_hand")).toEqual([
    "distance:left_hand,right_hand",
    "distance:right_hand,left_hand",
  ]);
  expect(bothSides("heading")).toEqual(["heading"]);
  expect(GAIT).toHaveLength(6);
  expect(keyOf({ document: "d", first: 1, last: 9, quantity: "time" })).toBe("d.1.9.time");
});
