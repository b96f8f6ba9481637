import { describe, expect, it } from "vitest";
import {
  angleAt,
  expressionOf,
  jointsOf,
  literal,
  measureOf,
  rowOf,
  withJoint,
  type Question,
  type Row,
} from "./question";
import { questionOf } from "./questionText";

const NAME: Row = { kind: "name", is: "is", name: "walk" };
const VALUE: Row = { kind: "value", bone: "left_up_arm", channel: "Rx", than: ">", value: 45 };
const FRAMES: Row = { kind: "frames", first: 20, last: 10 };
const SPEED: Row = measureOf("speed", "left_hand", []);
const GROUND: Row = { kind: "contact", is: true, joint: "right_toes" };
const all = (...rows: Row[]) => expressionOf({ rows, all: true });

describe("a question of rows", () => {
  it("is an expression over frames", () => {
    expect(all()).toBe("//frame");
    expect(all(NAME)).toBe("//frame[motion_name = 'walk']");
    expect(all(NAME, VALUE)).toBe("//frame[motion_name = 'walk' and frame_bone[@name = 'left_up_arm']/@Rx > 45]");
    expect(all({ ...NAME, is: "not" })).toBe("//frame[not(motion_name = 'walk')]");
    expect(all({ ...NAME, is: "contains" })).toBe("//frame[motion_name[contains(., 'walk')]]");
  });

  it("asks for bodies, while and then", () => {
    expect(all(SPEED, GROUND)).toBe("//frame[mo:speed('left_hand') > 1 and mo:contact('right_toes')]");
    expect(all(SPEED, { ...GROUND, is: false, within: 1 }, { ...NAME, within: 0.5 })).toBe(
      "//frame[mo:speed('left_hand') > 1 and mo:window(0, 1)[not(mo:contact('right_toes')) and mo:window(0, 0.5)[motion_name = 'walk']]]",
    );
    expect(expressionOf({ rows: [SPEED, NAME, { ...GROUND, within: 1 }], all: false })).toBe(
      "//frame[(mo:speed('left_hand') > 1 or motion_name = 'walk') and mo:window(0, 1)[mo:contact('right_toes')]]",
    );
    expect(all(measureOf("above", "left_hand", ["Head"]))).toBe("//frame[mo:height('left_hand') > mo:height('Head')]");
  });

  it("keeps together what belongs together where any row will do", () => {
    expect(expressionOf({ rows: [NAME, FRAMES], all: false })).toBe(
      "//frame[motion_name = 'walk' or (position() >= 10 and position() <= 20)]",
    );
    expect(expressionOf({ rows: [{ ...NAME, name: "a and b" }, VALUE], all: false })).toBe(
      "//frame[motion_name = 'a and b' or frame_bone[@name = 'left_up_arm']/@Rx > 45]",
    );
  });

  it("leaves out rows that say nothing yet", () => {
    expect(all({ ...NAME, name: "" }, { ...VALUE, value: Number.NaN }, { ...FRAMES, first: Number.NaN }, VALUE)).toBe(
      "//frame[frame_bone[@name = 'left_up_arm']/@Rx > 45]",
    );
    expect(all({ ...NAME, name: "" }, { ...GROUND, within: 1 })).toBe("//frame[mo:contact('right_toes')]");
  });

  it("begins with what there is", () => {
    expect(rowOf("name", { names: ["kick"], joints: [] })).toEqual({ kind: "name", is: "is", name: "kick" });
    expect(rowOf("value", { names: [], joints: ["Root", "left_low_arm"] })).toMatchObject({ bone: "left_low_arm" });
    expect(rowOf("value", { names: [], joints: [] })).toMatchObject({ bone: "" });
    expect(rowOf("measure", { names: [], joints: ["Root"] }, "Head")).toMatchObject({ joint: "Head" });
  });

  it("takes the joint that is picked", () => {
    const knee = withJoint(measureOf("angle", "left_hand", []), "right_low_leg");
    expect(knee).toMatchObject({ joint: "right-knee-flexion" });
    expect(jointsOf(knee)).toEqual(["right_low_leg"]);
    const apart = measureOf("distance", "left_hand", ["left_hand", "right_hand", "Head"]);
    expect(jointsOf(apart)).toEqual(["left_hand", "right_hand"]);
    expect(jointsOf(withJoint(apart, "Head", true))).toEqual(["left_hand", "Head"]);
    expect(withJoint(NAME, "Head")).toBe(NAME);
    expect(angleAt("tail")).toBeNull();
  });
});

describe("an expression", () => {
  const CHOICES: Row[] = [
    NAME,
    { ...NAME, is: "not", name: `it's "so"` },
    { ...NAME, is: "contains", name: "a'b and c" },
    VALUE,
    { ...VALUE, than: "!=", value: -4.25 },
    { kind: "frames", first: 10, last: 20 },
    SPEED,
    { kind: "measure", quantity: "height", joint: "Head", other: "", than: "<", value: 1.25 },
    { kind: "measure", quantity: "angle", joint: "left-knee-flexion", other: "", than: ">", value: 45 },
    { kind: "measure", quantity: "distance", joint: "left_hand", other: "right_hand", than: "<", value: 0.3 },
    { kind: "measure", quantity: "above", joint: "left_hand", other: "Head", than: ">", value: 0 },
    GROUND,
    { ...GROUND, is: false },
    { kind: "activity", is: true, name: "turn left" },
    { kind: "activity", is: false, name: "walk" },
  ];

  it("says its rows again, whatever they are", () => {
    let seed = 7;
    const draw = (most: number) => (seed = (seed * 16807) % 2147483647) % most;
    for (let turn = 0; turn < 3000; turn++) {
      const rows = Array.from({ length: draw(5) }, (_, at) => {
        const row = CHOICES[draw(CHOICES.length)]!;
        return at && !draw(3) ? { ...row, within: (1 + draw(8)) / 4 } : row;
      });
      const question: Question = { rows, all: draw(2) === 0 };
      const text = expressionOf(question);
      const read = questionOf(text, question.all);
      expect(read, text).toEqual(question);
      expect(expressionOf(read!)).toBe(text);
    }
  });

  it("may be written in other ways", () => {
    expect(questionOf(`  //frame[ motion_name="walk" ] [mo:contact( 'right_toes' )]`, true)).toEqual({
      rows: [NAME, GROUND],
      all: true,
    });
    expect(questionOf("//frame[(motion_name = 'walk' or (mo:contact('right_toes')))]", true)).toEqual({
      rows: [NAME, GROUND],
      all: false,
    });
  });

  it.each([
    "",
    "//frame/frame_bone",
    "/mcml//frame[motion_name = 'walk']",
    "//frame[motion_name != 'walk']",
    "//frame[motion_name = 'a' and (motion_name = 'b' or motion_name = 'c')]",
    "//frame[(motion_name = 'a' and motion_name = 'b') or motion_name = 'c']",
    "//frame[mo:speed('left_hand') > mo:speed('right_hand')]",
    "//frame[mo:speed('left_hand', 'Root') > 1]",
    "//frame[mo:speed('left_hand') >= 1]",
    "//frame[mo:window(-1, 0)[motion_name = 'a']]",
    "//frame[mo:window(0, 1)[motion_name = 'a']]",
    "//frame[mo:window(0, 1)[motion_name = 'a'] and motion_name = 'b']",
    "//frame[position() >= 3]",
    "//frame[position() >= 9 and position() <= 3]",
    "//frame[not(motion_name = 'a' or motion_name = 'b')]",
    "//frame[motion_name = 'a'",
    "//frame[motion_name = 'a']]",
    "//frame[motion_name = 'a'] | //name",
    "//frame[motion_name = 'it''s']",
    "mo:top(3, //frame[motion_name = 'a'])",
    "//frame[mo:speed('a') > 1e3]",
  ])("may be beyond rows: %s", (text) => {
    expect(questionOf(text, true)).toBeNull();
  });
});

describe("texts in an expression", () => {
  it("may hold quotes of both kinds", () => {
    expect(literal("a")).toBe("'a'");
    expect(literal("it's")).toBe(`"it's"`);
    expect(literal(`a"b`)).toBe(`'a"b'`);
    const evaluated = (text: string) => eval(literal(text).replace(/^concat\((.*)\)$/, "[$1].join('')")) as string;
    for (const text of [`it's "so"`, `'"`, `"'`, `''""`]) expect(evaluated(text)).toBe(text);
  });
});
