/** Quantities of a body as they are asked of the service, and the questions that they become. Pure functions. */

export const KINDS = ["height", "speed", "acceleration", "angle", "contact", "heading"] as const;
export type Kind = (typeof KINDS)[number];
/** argument: a joint or an angle; "" for what needs none. */
export interface Asked {
  kind: Kind;
  argument: string;
}

export const JOINT_KINDS: ReadonlySet<Kind> = new Set<Kind>(["height", "speed", "acceleration", "contact"]);
export const UNITS: Record<Kind, string> = {
  height: "m",
  speed: "m/s",
  acceleration: "m/s²",
  angle: "°",
  contact: "",
  heading: "°",
};
/** What is being typed where the service offers all names of angles. */
export const ANGLE = "//frame[mo:angle('";
const FIRST_ANGLE = "left-knee-flexion";
/** What a body may stand on, or reaches with: of these the first that it has. */
const PREFERRED = ["left_hand", "left_toes", "left_foot", "Head", "Root"];
const DIGITS = 4;

export const textOf = ({ kind, argument }: Asked): string => (argument ? `${kind}:${argument}` : kind);

/** The quantity of the address, else the height of the selected joint. */
export function startOf(text: string, selected: string | undefined, bones: readonly string[]): Asked {
  const [kind = "", argument = ""] = text.split(":", 2);
  if ((KINDS as readonly string[]).includes(kind)) {
    const found = { kind: kind as Kind, argument };
    return { ...found, argument: argumentOf(found.kind, found, bones) };
  }
  return { kind: "height", argument: selected ?? jointOf(bones) };
}

/** The argument that a kind takes; the one of before, where it takes it. */
export function argumentOf(kind: Kind, before: Asked, bones: readonly string[]): string {
  if (kind === "heading") return "";
  if (kind === "angle") return before.kind === "angle" && before.argument ? before.argument : FIRST_ANGLE;
  return JOINT_KINDS.has(before.kind) && bones.includes(before.argument) ? before.argument : jointOf(bones);
}

const jointOf = (bones: readonly string[]): string => PREFERRED.find((name) => bones.includes(name)) ?? bones[0] ?? "";

/** The frames in which it is above (or below) a threshold. */
export function expression({ kind, argument }: Asked, limit: number, above: boolean): string {
  const call = `mo:${kind}(${argument ? quoted(argument) : ""})`;
  return kind === "contact" ? `//frame[${call}]` : `//frame[${call} ${above ? ">" : "<"} ${limit}]`;
}

const quoted = (text: string): string => (text.includes("'") ? `"${text}"` : `'${text}'`);

/** The least and the greatest value; null where none is known. */
export function known(values: Float64Array): { low: number; high: number } | null {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value !== value) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? { low, high } : null;
}

export const rounded = (value: number): number => Number(value.toPrecision(DIGITS));

/** What a quantity rests on, the first first. */
export type Ground = "rate" | "unit" | "up" | "floor" | "leg";
const RESTS: Record<Kind, readonly Ground[]> = {
  height: ["unit", "up", "floor"],
  speed: ["rate", "unit"],
  acceleration: ["rate", "unit"],
  angle: [],
  contact: ["unit", "up", "floor", "rate"],
  heading: ["up"],
};

/** Why nothing is known of a quantity: the first thing that it rests on and that nobody knows; null: joints lack. */
export const causeOf = (kind: Kind, knows: (ground: Ground) => boolean): Ground | null =>
  RESTS[kind].find((ground) => !knows(ground)) ?? null;
