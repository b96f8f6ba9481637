/** JSON schemas of parameters as fields of a form: what a person can set without knowing JSON. */

export interface Schema {
  type?: string;
  title?: string;
  description?: string;
  default?: unknown;
  enum?: unknown[];
  const?: unknown;
  anyOf?: Schema[];
  items?: Schema;
  properties?: Record<string, Schema>;
  required?: string[];
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  exclusiveMaximum?: number;
  minLength?: number;
  maxLength?: number;
  $ref?: string;
  $defs?: Record<string, Schema>;
  additionalProperties?: boolean | Schema;
}

export type Kind = "truth" | "choice" | "choices" | "number" | "text" | "words" | "json";

export interface Field {
  name: string;
  title: string;
  help: string;
  kind: Kind;
  /** Of choices. */
  options: (string | number)[];
  whole: boolean;
  least?: number;
  most?: number;
  /** May be left empty: null, or the default. */
  optional: boolean;
  required: boolean;
  initial: unknown;
}

/** The fields of an object's schema, in its order. */
export function fieldsOf(schema: Schema): Field[] {
  return Object.entries(schema.properties ?? {}).map(([name, one]) => fieldOf(name, one, schema));
}

function fieldOf(name: string, given: Schema, root: Schema): Field {
  const plain = resolved(given, root);
  const choices = (plain.anyOf ?? [plain]).map((one) => resolved(one, root));
  const others = choices.filter((one) => one.type !== "null");
  const [first, ...more] = others;
  const one = first && !more.length ? first : mixed(others);
  return {
    name,
    title: given.title ?? name,
    help: given.description ?? "",
    ...kindOf(one, root),
    whole: one.type === "integer",
    least: one.minimum ?? one.exclusiveMinimum,
    most: one.maximum ?? one.exclusiveMaximum,
    optional: others.length < choices.length || given.default !== undefined,
    required: Boolean(root.required?.includes(name)),
    initial: given.default ?? null,
  };
}

const resolved = (one: Schema, root: Schema): Schema => {
  const name = one.$ref?.replace("#/$defs/", "");
  return name ? { ...root.$defs?.[name], ...one } : one;
};

/** Several kinds at once, such as a number or one word: JSON says all of them, unless all are words. */
function mixed(choices: Schema[]): Schema {
  const words = choices.flatMap((one) => one.enum ?? (one.const === undefined ? [undefined] : [one.const]));
  return words.includes(undefined) ? {} : { enum: words };
}

function kindOf(one: Schema, root: Schema): { kind: Kind; options: (string | number)[] } {
  const options = (one.enum ?? (one.const === undefined ? [] : [one.const])) as (string | number)[];
  if (options.length) return { kind: "choice", options };
  if (one.type === "boolean") return { kind: "truth", options };
  if (one.type === "number" || one.type === "integer") return { kind: "number", options };
  if (one.type === "string") return { kind: "text", options };
  const items = one.items && resolved(one.items, root);
  if (one.type === "array" && items?.enum) return { kind: "choices", options: items.enum as string[] };
  if (one.type === "array" && items?.type === "string") return { kind: "words", options };
  return { kind: "json", options };
}

/** What was written in a field as a value; undefined for one left as it is. Error for what it cannot be. */
export function valueOf(field: Field, text: string): unknown {
  const trimmed = text.trim();
  if (!trimmed) return undefined;
  if (field.kind === "number") {
    const value = Number(trimmed);
    if (!Number.isFinite(value) || (field.whole && !Number.isInteger(value))) throw new Error("number");
    if ((field.least !== undefined && value < field.least) || (field.most !== undefined && value > field.most))
      throw new Error("range");
    return value;
  }
  if (field.kind === "choice") return field.options.find((one) => String(one) === trimmed);
  if (field.kind === "words")
    return trimmed
      .split(",")
      .map((one) => one.trim())
      .filter(Boolean);
  if (field.kind !== "json") return trimmed;
  try {
    return JSON.parse(trimmed) as unknown;
  } catch {
    if (/^[[{"]/.test(trimmed)) throw new Error("json");
    return trimmed; // A word where a number or a word may stand.
  }
}

/** A value as its field writes it. */
export function textOf(field: Field, value: unknown): string {
  if (value === undefined || value === null) return "";
  if (field.kind === "words") return (value as string[]).join(", ");
  return field.kind === "json" && typeof value !== "string" ? JSON.stringify(value) : String(value);
}
