import { entryOf } from "../../lists";
import { describe, expect, it } from "vitest";
import { fieldsOf, textOf, valueOf, type Schema } from "./schema";

const schema: Schema = {
  $defs: { Mode: { enum: ["a", "b"], type: "string" } },
  required: ["who"],
  properties: {
    who: { type: "string", title: "Who" },
    on: { type: "boolean", default: true },
    rate: {
      anyOf: [{ type: "number", minimum: 40, maximum: 240 }, { type: "null" }],
      default: null,
      description: "beats",
    },
    bars: { type: "integer", default: 16, minimum: 1 },
    mode: { $ref: "#/$defs/Mode", default: "a" },
    step: { enum: [1, 4], default: 4, type: "integer" },
    near: { anyOf: [{ type: "number" }, { const: "window", type: "string" }], default: 0.2 },
    labels: { type: "array", items: { enum: ["bars", "beats"], type: "string" } },
    names: { type: "array", items: { type: "string" } },
    clips: { type: "array", items: { type: "object" } },
  },
};

describe("fields of a schema", () => {
  const fields = Object.fromEntries(fieldsOf(schema).map((one) => [one.name, one]));
  it("are of the kind that their types say", () => {
    expect(Object.values(fields).map((one) => one.kind)).toEqual([
      "text",
      "truth",
      "number",
      "number",
      "choice",
      "choice",
      "json",
      "choices",
      "words",
      "json",
    ]);
    expect(fields.rate).toMatchObject({
      least: 40,
      most: 240,
      optional: true,
      required: false,
      help: "beats",
      initial: null,
    });
    expect(fields.who).toMatchObject({ required: true, optional: false });
    expect(fields.step!.options).toEqual([1, 4]);
  });

  it("take what they may be, and nothing else", () => {
    expect(valueOf(fields.rate!, "")).toBeUndefined();
    expect(valueOf(fields.rate!, " 120.5 ")).toBe(120.5);
    expect(() => valueOf(fields.rate!, "39")).toThrow("range");
    expect(() => valueOf(fields.bars!, "1.5")).toThrow("number");
    expect(() => valueOf(fields.bars!, "many")).toThrow("number");
    expect(valueOf(fields.step!, "4")).toBe(4);
    expect(valueOf(fields.near!, "window")).toBe("window");
    expect(valueOf(fields.near!, "0.3")).toBe(0.3);
    expect(valueOf(fields.names!, "a, b,")).toEqual(["a", "b"]);
    expect(valueOf(fields.clips!, '[{"document": "x"}]')).toEqual([{ document: "x" }]);
    expect(() => valueOf(fields.clips!, "[{")).toThrow("json");
  });

  it("write what they read", () => {
    for (const [name, value] of [
      ["rate", 120.5],
      ["names", ["a", "b"]],
      ["clips", [{ a: 1 }]],
      ["near", "window"],
      ["mode", "b"],
    ] as const) {
      expect(valueOf(entryOf(fields, name), textOf(entryOf(fields, name), value))).toEqual(value);
    }
  });
});
