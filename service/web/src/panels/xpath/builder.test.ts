import { describe, expect, it } from "vitest";
import { expressionOf, literal, rowOf, type Row } from "./builder";

const NAME: Row = { kind: "name", is: "is", name: "walk" };
const VALUE: Row = { kind: "value", bone: "left_up_arm", channel: "Rx", than: ">", value: 45 };
const FRAMES: Row = { kind: "frames", first: 20, last: 10 };
const all = (...rows: Row[]) => expressionOf({ rows, all: true });

describe("a question of rows", () => {
  it("is an expression over frames", () => {
    expect(all()).toBe("//frame");
    expect(all(NAME)).toBe("//frame[motion_name = 'walk']");
    expect(all(NAME, VALUE)).toBe("//frame[motion_name = 'walk' and frame_bone[@name = 'left_up_arm']/@Rx > 45]");
    expect(all({ ...NAME, is: "not" })).toBe("//frame[not(motion_name = 'walk')]");
    expect(all({ ...NAME, is: "contains" })).toBe("//frame[motion_name[contains(., 'walk')]]");
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
  });

  it("begins with what there is", () => {
    expect(rowOf("name", ["kick"], [])).toEqual({ kind: "name", is: "is", name: "kick" });
    expect(rowOf("value", [], ["Root", "left_low_arm"])).toMatchObject({ bone: "left_low_arm" });
    expect(rowOf("value", [], [])).toMatchObject({ bone: "" });
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
