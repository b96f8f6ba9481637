import { describe, expect, it } from "vitest";
import { partNamed, partsOf, usualPart } from "./parts";

const body = (text: string) => {
  const names: string[] = [];
  return text.split(" ").map((part) => {
    const [name = "", parent] = part.split("<");
    names.push(name);
    return {
      name,
      parent: parent ? names.indexOf(parent) : -1,
      side: name.startsWith("left")
        ? ("left" as const)
        : name.startsWith("right")
          ? ("right" as const)
          : ("centre" as const),
    };
  });
};
const PERSON = body(
  "Root waist<Root torso7<waist neck1<torso7 Head<neck1 left_shoulder<torso7 left_up_arm<left_shoulder left_prop<left_up_arm right_up_arm<torso7 left_up_leg<Root left_foot<left_up_leg right_hip<Root right_toes<right_hip",
);

describe("parts of a body", () => {
  it("are found by names, with all that hangs on them", () => {
    const parts = partsOf(PERSON);
    expect(parts.leftArm).toEqual(["left_shoulder", "left_up_arm", "left_prop"]);
    expect(parts.rightArm).toEqual(["right_up_arm"]);
    expect(parts.arms).toEqual([...parts.leftArm, ...parts.rightArm]);
    expect(parts.legs).toEqual(["left_up_leg", "left_foot", "right_hip", "right_toes"]);
    expect(parts.head).toEqual(["neck1", "Head"]);
    expect(parts.upper).toEqual(["waist", "torso7", "neck1", "Head", ...parts.leftArm, "right_up_arm"]);
  });

  it("are named again whatever the order, and others are of no name", () => {
    expect(partNamed(PERSON, [...partsOf(PERSON).arms].reverse())).toBe("arms");
    expect(partNamed(PERSON, ["Head"])).toBe(null);
    expect(partNamed(body("a b<a"), [])).toBe(null);
  });

  it("of a body of other names: all but its root", () => {
    expect(usualPart(PERSON)).toEqual(partsOf(PERSON).upper);
    expect(usualPart(body("a b<a c<b"))).toEqual(["b", "c"]);
  });
});
