import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { addable, completions, placeOf, readDtd, written } from "./dtd";

const dtd = readDtd(readFileSync(new URL("../../../../../mcml.dtd", import.meta.url), "utf8"));
const kind = (name: string) => dtd.get(name)!;

describe("mcml.dtd", () => {
  it("says what stands where, in which order, and what must", () => {
    expect(kind("mcml").children.map((one) => [one.name, one.rank, one.required])).toEqual([
      ["header", 0, true],
      ["root", 1, false],
      ["skeleton", 2, true],
      ["motion", 3, true],
    ]);
    const bone = kind("bone").children;
    expect(bone[0]).toEqual({ name: "name", rank: 0, required: true, many: false });
    expect(bone.filter((one) => one.many).map((one) => [one.name, one.rank])).toEqual([
      ["limits", 7],
      ["bone", 10],
      ["end_site", 10],
    ]);
    expect(kind("skeleton").children).toEqual([{ name: "bone", rank: 0, required: false, many: true }]);
    expect([kind("name").text, kind("property").text, kind("name").children]).toEqual([true, false, []]);
    expect(kind("property").attributes).toEqual([
      { name: "name", required: true },
      { name: "value", required: true },
      { name: "unit", required: false },
    ]);
    expect(kind("bone").attributes.find((one) => one.name === "mapped")?.values).toEqual(["true", "false"]);
  });

  it("tells the editor all elements", () => {
    const found = completions(dtd);
    expect(found.filter((one) => one.top).map((one) => one.name)).toEqual(["mcml"]);
    expect(found.find((one) => one.name === "bone")?.children).toContain("end_site");
    expect(found.every((one) => one.children!.every((child) => dtd.has(child)))).toBe(true);
  });

  it("says what can be added, and where it belongs", () => {
    expect(addable(kind("bone"), ["name", "position", "bone"])).toEqual([
      "direction",
      "length",
      "axis",
      "order",
      "dof",
      "limits",
      "bodymass",
      "cofmass",
      "bone",
      "end_site",
    ]);
    expect(placeOf(kind("bone"), ["name", "position", "bone"], "limits")).toBe(1);
    expect(placeOf(kind("bone"), ["name", "position", "bone"], "bone")).toBe(2);
    expect(placeOf(kind("header"), ["description"], "filetype")).toBe(-1);
    expect(placeOf(kind("skeleton"), [], "bone")).toBe(-1);
    expect(addable(kind("name"), [])).toEqual([]);
  });

  it("writes an element with what must be in it", () => {
    expect(
      written(
        kind("property"),
        new Map([
          ["@name", "a&b"],
          ["@value", '"2"'],
        ]),
      ),
    ).toBe('<property name="a&amp;b" value="&quot;2&quot;"/>');
    expect(
      written(
        kind("bone"),
        new Map([
          ["name", "tail"],
          ["@id", "7"],
        ]),
      ),
    ).toBe('<bone id="7"><name>tail</name></bone>');
    expect(written(kind("description"), new Map([["", "a < b"]]))).toBe("<description>a &lt; b</description>");
  });
});
