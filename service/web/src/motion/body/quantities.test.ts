import { describe, expect, it, test } from "vitest";
import {
  argumentOf,
  causeOf,
  expression,
  known,
  measuredArgument,
  nameAndAxis,
  rounded,
  startOf,
  textOf,
} from "./quantities";

const bones = ["Root", "left_hand", "it's"];

test("the address says what is shown, else the selected joint", () => {
  expect(startOf("", "Root", bones)).toEqual({ kind: "height", argument: "Root" });
  expect(startOf("", undefined, bones)).toEqual({ kind: "height", argument: "left_hand" });
  expect(startOf("speed:Root", undefined, bones)).toEqual({ kind: "speed", argument: "Root" });
  expect(startOf("speed:nothing", undefined, bones)).toEqual({ kind: "speed", argument: "left_hand" });
  expect(startOf("heading", "Root", bones)).toEqual({ kind: "heading", argument: "" });
  expect(startOf("nonsense:Root", undefined, [])).toEqual({ kind: "height", argument: "" });
});

test("another kind keeps the joint where it takes one", () => {
  expect(argumentOf("speed", { kind: "height", argument: "Root" }, bones)).toBe("Root");
  expect(argumentOf("angle", { kind: "height", argument: "Root" }, bones)).toBe("left-knee-flexion");
  expect(argumentOf("height", { kind: "angle", argument: "left-knee-flexion" }, bones)).toBe("left_hand");
  expect(textOf({ kind: "angle", argument: "left-knee-flexion" })).toBe("angle:left-knee-flexion");
});

test("positions are of a joint along an axis", () => {
  const asked = startOf("position:Root,front", undefined, bones);
  expect(asked).toEqual({ kind: "position", argument: "Root,front" });
  expect(argumentOf("position", { kind: "speed", argument: "Root" }, bones)).toBe("Root,up");
  expect(argumentOf("speed", asked, bones)).toBe("Root");
  expect(startOf("position:nobody,sideways", undefined, bones).argument).toBe("left_hand,up");
  expect(expression(asked, 0.5, true)).toBe("//frame[mo:position('Root', 'front') > 0.5]");
});

test("contacts are of joints or of the feet of a walker", () => {
  expect(startOf("contact:left", undefined, bones)).toEqual({ kind: "contact", argument: "left" });
  expect(argumentOf("contact", { kind: "contact", argument: "Root" }, bones)).toBe("Root");
  expect(argumentOf("height", { kind: "contact", argument: "right" }, bones)).toBe("left_hand");
  expect(expression({ kind: "contact", argument: "left" }, 0, true)).toBe("//frame[mo:contact('left')]");
});

test("a threshold becomes a question", () => {
  expect(expression({ kind: "height", argument: "left_hand" }, 1.5, true)).toBe(
    "//frame[mo:height('left_hand') > 1.5]",
  );
  expect(expression({ kind: "heading", argument: "" }, -90, false)).toBe("//frame[mo:heading() < -90]");
  expect(expression({ kind: "contact", argument: "it's" }, 0, true)).toBe('//frame[mo:contact("it\'s")]');
});

test("a measurement of the file has a name, and most an axis", () => {
  const knee = { function: "quantity", name: "Anna:LKneeAngles", axes: ["x", "y", "z"], unit: "deg", reason: "" };
  expect(measuredArgument(knee, "")).toBe("Anna:LKneeAngles,x");
  expect(measuredArgument(knee, "z")).toBe("Anna:LKneeAngles,z");
  expect(measuredArgument({ ...knee, function: "analog", name: "EMG, left", axes: [] }, "z")).toBe("EMG, left");
  const asked = startOf("quantity:Anna:LKneeAngles,x", "Root", bones);
  expect(asked).toEqual({ kind: "quantity", argument: "Anna:LKneeAngles,x" });
  expect(expression(asked, 60, true)).toBe("//frame[mo:quantity('Anna:LKneeAngles', 'x') > 60]");
  expect(nameAndAxis({ kind: "analog", argument: "EMG, left" })).toEqual(["EMG, left", ""]);
  expect(expression({ kind: "free-moment", argument: "1" }, 3, false)).toBe("//frame[mo:free-moment('1') < 3]");
});

test("what is not known has no ends", () => {
  expect(known(Float64Array.of(NaN, 3, -1, NaN))).toEqual({ low: -1, high: 3 });
  expect(known(Float64Array.of(NaN))).toBeNull();
  expect(rounded(1234.567)).toBe(1235);
});

describe("why nothing is known", () => {
  it("names the one cause, the first that has to be mended", () => {
    const lacks =
      (...grounds: string[]) =>
      (ground: string) =>
        !grounds.includes(ground);
    expect(causeOf("height", lacks("floor"))).toBe("floor");
    expect(causeOf("height", lacks("unit", "floor"))).toBe("unit");
    expect(causeOf("speed", lacks("rate", "floor"))).toBe("rate");
    expect(causeOf("speed", lacks("floor"))).toBe(null);
    expect(causeOf("angle", lacks("unit", "floor", "rate"))).toBe(null);
    expect(causeOf("contact", lacks("floor"))).toBe("floor");
    expect(causeOf("heading", lacks("up"))).toBe("up");
  });
});
