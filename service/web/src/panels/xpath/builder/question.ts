/** A query as rows of conditions, and as the XPath that it is. `questionText.ts` reads the XPath back. */
export const CHANNELS = ["Rx", "Ry", "Rz", "Tx", "Ty", "Tz"] as const;
export const COMPARISONS = [">", "<", ">=", "<=", "=", "!="] as const;
/** Measurements of a body in a frame. `above`: the height over that of another joint. */
export const QUANTITIES = ["speed", "height", "angle", "distance", "above"] as const;
export type QuantityName = (typeof QUANTITIES)[number];
export const UNITS: Record<QuantityName, string> = { speed: "m/s", height: "m", angle: "°", distance: "m", above: "" };

/** joint: a name of a joint, of an angle the name of its movement. other: the second joint of a distance, and of `above`. */
export interface MeasureRow {
  kind: "measure";
  quantity: QuantityName;
  joint: string;
  other: string;
  than: ">" | "<";
  value: number;
}
export type Condition =
  | MeasureRow
  | { kind: "contact"; is: boolean; joint: string }
  | { kind: "activity"; is: boolean; name: string }
  | { kind: "name"; is: "is" | "not" | "contains"; name: string }
  | {
      kind: "value";
      bone: string;
      channel: (typeof CHANNELS)[number];
      than: (typeof COMPARISONS)[number];
      value: number;
    }
  | { kind: "frames"; first: number; last: number };
export type RowKind = Condition["kind"];
/** within: seconds after a frame of the rows above, in which a frame of this row and the next ones is; else the same frame. */
export type Row = Condition & { within?: number };

export interface Question {
  rows: readonly Row[];
  /** Every row of the same frame, or any one. */ all: boolean;
}
export const NO_QUESTION: Question = { rows: [], all: true };
const USUAL: Record<QuantityName, number> = { speed: 1, height: 1, angle: 45, distance: 0.3, above: 0 };
const FIRST_ANGLE = "left-knee-flexion";

export interface Known {
  names: readonly string[];
  joints: readonly string[];
}

const firstOf = (joints: readonly string[], ...wanted: string[]): string =>
  wanted.find((one) => joints.includes(one)) ?? joints[0] ?? "";

/** A row of a kind, with what is likely. joint: chosen already. */
export function rowOf(kind: RowKind, { names, joints }: Known, joint = ""): Row {
  if (kind === "name") return { kind, is: "is", name: names[0] ?? "" };
  if (kind === "activity") return { kind, is: true, name: "walk" };
  if (kind === "frames") return { kind, first: 1, last: 100 };
  if (kind === "contact") return { kind, is: true, joint: joint || firstOf(joints, "right_toes", "right_foot") };
  if (kind === "measure") return measureOf("speed", joint || firstOf(joints, "left_hand", "Root"), joints);
  const bone = joint || (joints.find((one) => /left_(up|low)_arm/.test(one)) ?? joints[0] ?? "");
  return { kind, bone, channel: "Rx", than: ">", value: 45 };
}

/** A measurement of a joint; an angle is that of its movement. */
export function measureOf(quantity: QuantityName, joint: string, joints: readonly string[]): MeasureRow {
  const pair = quantity === "distance" || quantity === "above";
  const opposite = joint.startsWith("left_") ? joint.replace("left_", "right_") : joint.replace("right_", "left_");
  const other = quantity === "above" ? firstOf(joints, "Head") : firstOf(joints, opposite, "right_hand");
  return {
    kind: "measure",
    quantity,
    joint: quantity === "angle" ? (angleAt(joint) ?? FIRST_ANGLE) : joint,
    other: pair ? other : "",
    than: quantity === "distance" ? "<" : ">",
    value: USUAL[quantity],
  };
}

const MOVEMENTS: Record<string, string> = {
  up_leg: "hip-flexion",
  low_leg: "knee-flexion",
  foot: "ankle-dorsiflexion",
  toes: "ankle-dorsiflexion",
  up_arm: "arm-abduction",
  low_arm: "elbow-flexion",
  hand: "wrist-flexion",
};

/** The first movement of a joint: left-knee-flexion of left_low_leg. */
export function angleAt(joint: string): string | null {
  if (joint === "Head") return "head-flexion";
  if (joint === "Root") return "pelvis-tilt";
  if (/^(neck|waist|torso)/.test(joint)) return joint.startsWith("neck") ? "neck-flexion" : "trunk-flexion";
  const [, side, part = ""] = /^(left|right)_(.+)$/.exec(joint) ?? [];
  const movement = MOVEMENTS[part];
  return side && movement ? `${side}-${movement}` : null;
}

/** The joint of a body that the movement of an angle is at, "" for another. */
export function jointOfAngle(angle: string): string {
  const [, side, movement = ""] = /^(left|right)-(.+)$/.exec(angle) ?? [];
  if (!side) return { "head-flexion": "Head", "pelvis-tilt": "Root" }[angle] ?? "";
  const limb = movement.split("-")[0] ?? "";
  const part = Object.keys(MOVEMENTS).find((one) => MOVEMENTS[one]?.startsWith(`${limb}-`));
  return part ? `${side}_${part}` : "";
}

/** A row with a joint that was picked on a body. second: as the other joint of two. */
export function withJoint(row: Row, joint: string, second = false): Row {
  if (row.kind === "contact") return { ...row, joint };
  if (row.kind === "value") return { ...row, bone: joint };
  if (row.kind !== "measure") return row;
  if (row.quantity === "angle") return { ...row, joint: angleAt(joint) ?? row.joint };
  return second && row.other ? { ...row, other: joint } : { ...row, joint };
}

/** The joints that a row is about. */
export function jointsOf(row: Row): string[] {
  if (row.kind === "contact") return [row.joint];
  if (row.kind === "value") return [row.bone];
  if (row.kind !== "measure") return [];
  if (row.quantity === "angle") return [jointOfAngle(row.joint)].filter(Boolean);
  return row.other ? [row.joint, row.other] : [row.joint];
}

/** A measurement as the service names it, `speed:left_hand`; null where a row compares none with a number. */
export function quantityOf(row: Row): string | null {
  if (row.kind !== "measure" || row.quantity === "above" || !row.joint) return null;
  return `${row.quantity}:${row.joint}${row.quantity === "distance" ? `,${row.other}` : ""}`;
}

/** A text as XPath writes it, whatever quotes are in it. */
export function literal(text: string): string {
  if (!text.includes("'")) return `'${text}'`;
  if (!text.includes('"')) return `"${text}"`;
  return `concat(${text
    .split("'")
    .map((part) => `'${part}'`)
    .join(`, "'", `)})`;
}

/** The frames that a question asks for. Rows that say nothing yet are left out. */
export function expressionOf({ rows, all }: Question): string {
  const steps: { within: number; conditions: string[] }[] = [];
  for (const row of rows) {
    const condition = conditionOf(row);
    const last = steps.at(-1);
    if (condition && (!last || row.within !== undefined)) {
      steps.push({ within: row.within ?? 0, conditions: [condition] });
    } else if (condition) last?.conditions.push(condition);
  }
  let text = "";
  for (const { within, conditions } of steps.reverse()) {
    const together = joinConditions(conditions, all, text !== "");
    const whole = text ? `${together} and ${text}` : together;
    text = steps.at(-1)?.conditions === conditions ? `//frame[${whole}]` : `mo:window(0, ${within})[${whole}]`;
  }
  return text || "//frame";
}

/** Conditions of one frame. within: as a part of others that hold too. */
function joinConditions(conditions: string[], all: boolean, within: boolean): string {
  if (all || conditions.length === 1) return conditions.join(" and ");
  const text = conditions
    .map((one) => (/ and /.test(one.replace(/'[^']*'|"[^"]*"/g, "")) ? `(${one})` : one))
    .join(" or ");
  return within ? `(${text})` : text;
}

function conditionOf(row: Row): string {
  switch (row.kind) {
    case "frames": {
      const [least, most] = [Math.min(row.first, row.last), Math.max(row.first, row.last)];
      return Number.isFinite(least + most) ? `position() >= ${least} and position() <= ${most}` : "";
    }
    case "name": {
      if (!row.name) return "";
      if (row.is === "contains") return `motion_name[contains(., ${literal(row.name)})]`;
      return row.is === "is" ? `motion_name = ${literal(row.name)}` : `not(motion_name = ${literal(row.name)})`;
    }
    case "activity":
      return row.name ? negated(`mo:activity(${literal(row.name)})`, row.is) : "";
    case "contact":
      return row.joint ? negated(`mo:contact(${literal(row.joint)})`, row.is) : "";
    case "value": {
      if (!row.bone || !Number.isFinite(row.value)) return "";
      return `frame_bone[@name = ${literal(row.bone)}]/@${row.channel} ${row.than} ${row.value}`;
    }
    case "measure":
      return comparisonOf(row);
  }
}

const negated = (text: string, is: boolean): string => (is ? text : `not(${text})`);

function comparisonOf({ quantity, joint, other, than, value }: MeasureRow): string {
  if (!joint || (other === "" && (quantity === "distance" || quantity === "above"))) return "";
  if (quantity === "above") return `mo:height(${literal(joint)}) ${than} mo:height(${literal(other)})`;
  if (!Number.isFinite(value)) return "";
  const names = quantity === "distance" ? `${literal(joint)}, ${literal(other)}` : literal(joint);
  return `mo:${quantity}(${names}) ${than} ${value}`;
}
