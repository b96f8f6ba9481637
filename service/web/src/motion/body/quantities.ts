/** Quantities of a body as they are asked of the service, and the questions that they become. Pure functions. */

export const KINDS = ["height", "position", "speed", "acceleration", "angle", "contact", "heading"] as const;
/** Measurements of the file itself. */
export const FILE_KINDS = ["quantity", "force", "cop", "free-moment", "analog"] as const;
export type FileKind = (typeof FILE_KINDS)[number];
export type Kind = (typeof KINDS)[number] | FileKind;
/** A measurement of the file, as the service lists it. */
export interface Measured {
  function: string;
  name: string;
  axes: string[];
  unit: string;
  reason: string;
}
/** argument: a joint, an angle, or name and axis of a measurement of the file; "" for what needs none. */
export interface Asked {
  kind: Kind;
  argument: string;
}

export const JOINT_KINDS: ReadonlySet<Kind> = new Set<Kind>(["height", "speed", "acceleration", "contact"]);
/** Arguments of contacts that are the feet of a walker, from strike to off. */
export const FEET = ["left", "right"] as const;
export const UNITS: Record<Kind, string> = {
  height: "m",
  position: "m",
  speed: "m/s",
  acceleration: "m/s²",
  angle: "°",
  contact: "",
  heading: "°",
  quantity: "",
  force: "N",
  cop: "m",
  "free-moment": "N m",
  analog: "",
};
const WITH_AXIS: ReadonlySet<Kind> = new Set<Kind>(["position", "quantity", "force", "cop"]);
/** Axes of a position: of the space, or of the body in it. */
export const PLACE_AXES = ["x", "y", "z", "up", "front", "left"] as const;
export const isOfFile = (kind: Kind): kind is FileKind => (FILE_KINDS as readonly string[]).includes(kind);
/** What is being typed where the service offers all names of angles. */
export const ANGLE = "//frame[mo:angle('";
const FIRST_ANGLE = "left-knee-flexion";
/** What a body may stand on, or reaches with: of these the first that it has. */
const PREFERRED = ["left_hand", "left_toes", "left_foot", "Head", "Root"];
const DIGITS = 4;

export const textOf = ({ kind, argument }: Asked): string => (argument ? `${kind}:${argument}` : kind);

/** The quantity of the address, else the height of the selected joint. */
export function startOf(text: string, selected: string | undefined, bones: readonly string[]): Asked {
  const colon = text.indexOf(":");
  const kind = colon < 0 ? text : text.slice(0, colon);
  const argument = colon < 0 ? "" : text.slice(colon + 1);
  if (isOfFile(kind as Kind) && argument) return { kind: kind as Kind, argument };
  if ((KINDS as readonly string[]).includes(kind)) {
    const found = { kind: kind as Kind, argument };
    return { ...found, argument: argumentOf(found.kind, found, bones) };
  }
  return { kind: "height", argument: selected ?? jointOf(bones) };
}

/** A joint and an axis; those of before, where they are. */
function placeOf(before: Asked, bones: readonly string[]): string {
  const [joint, axis] = before.kind === "position" ? nameAndAxis(before) : [before.argument, ""];
  const along = PLACE_AXES.find((one) => one === axis) ?? "up";
  return `${bones.includes(joint) ? joint : jointOf(bones)},${along}`;
}

/** The argument that a kind takes; the one of before, where it takes it. */
export function argumentOf(kind: Kind, before: Asked, bones: readonly string[]): string {
  if (kind === "heading") return "";
  if (kind === "angle") return before.kind === "angle" && before.argument ? before.argument : FIRST_ANGLE;
  if (kind === "position") return placeOf(before, bones);
  if (kind === "contact" && before.kind === kind && FEET.some((side) => side === before.argument))
    return before.argument;
  const joint = before.kind === "position" ? nameAndAxis(before)[0] : before.argument;
  return (JOINT_KINDS.has(before.kind) || before.kind === "position") && bones.includes(joint) ? joint : jointOf(bones);
}

const jointOf = (bones: readonly string[]): string => PREFERRED.find((name) => bones.includes(name)) ?? bones[0] ?? "";

/** Name and axis of a measurement of the file; the axis is "" where it has none. */
export function nameAndAxis({ kind, argument }: Asked): [string, string] {
  const comma = argument.lastIndexOf(",");
  return WITH_AXIS.has(kind) && comma >= 0 ? [argument.slice(0, comma), argument.slice(comma + 1)] : [argument, ""];
}

/** The argument for a measurement of the file: along the axis of before, where it has it. */
export function measuredArgument({ name, axes }: Measured, axis: string): string {
  const along = axes.includes(axis) ? axis : axes[0];
  return along === undefined ? name : `${name},${along}`;
}

/** The frames in which it is above (or below) a threshold. */
export function expression(asked: Asked, limit: number, above: boolean): string {
  const { kind, argument } = asked;
  const parts = WITH_AXIS.has(kind) || isOfFile(kind) ? nameAndAxis(asked).filter(Boolean) : argument ? [argument] : [];
  const call = `mo:${kind}(${parts.map(quoted).join(", ")})`;
  return kind === "contact" ? `//frame[${call}]` : `//frame[${call} ${above ? ">" : "<"} ${limit}]`;
}

const quoted = (text: string): string => (text.includes("'") ? `"${text}"` : `'${text}'`);

/** Frames that `expression` finds. */
export const countHits = (values: Float64Array, kind: Kind, limit: number, above: boolean): number =>
  values.reduce(
    (sum, value) => sum + Number(kind === "contact" ? value === 1 : above ? value > limit : value < limit),
    0,
  );

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
  position: ["unit"],
  speed: ["rate", "unit"],
  acceleration: ["rate", "unit"],
  angle: [],
  contact: ["unit", "up", "floor", "rate"],
  heading: ["up"],
  quantity: [],
  force: [],
  cop: [],
  "free-moment": [],
  analog: [],
};

/** Why nothing is known of a quantity: the first thing that it rests on and that nobody knows; null: joints lack. */
export const causeOf = (kind: Kind, knows: (ground: Ground) => boolean): Ground | null =>
  RESTS[kind].find((ground) => !knows(ground)) ?? null;
