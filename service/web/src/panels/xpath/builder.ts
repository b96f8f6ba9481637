/** A question as rows of choices, and as the XPath that it is. */
export const CHANNELS = ["Rx", "Ry", "Rz", "Tx", "Ty", "Tz"] as const;
export const COMPARISONS = [">", "<", ">=", "<=", "=", "!="] as const;

export type Row =
  | { kind: "name"; is: "is" | "not" | "contains"; name: string }
  | {
      kind: "value";
      bone: string;
      channel: (typeof CHANNELS)[number];
      than: (typeof COMPARISONS)[number];
      value: number;
    }
  | { kind: "frames"; first: number; last: number };
export type RowKind = Row["kind"];

export interface Question {
  rows: readonly Row[];
  /** Every row, or any one. */ all: boolean;
}
export const NO_QUESTION: Question = { rows: [], all: true };

/** A row of a kind, with what is likely. */
export function rowOf(kind: RowKind, names: readonly string[], bones: readonly string[]): Row {
  if (kind === "name") return { kind, is: "is", name: names[0] ?? "" };
  if (kind === "frames") return { kind, first: 1, last: 100 };
  return {
    kind,
    bone: bones.find((one) => /left_(up|low)_arm/.test(one)) ?? bones[0] ?? "",
    channel: "Rx",
    than: ">",
    value: 45,
  };
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
  const conditions = rows.map(conditionOf).filter((one) => one !== "");
  if (!conditions.length) return "//frame";
  if (conditions.length === 1) return `//frame[${conditions[0]}]`;
  const held = conditions.map((one) => (!all && / and /.test(one.replace(/'[^']*'|"[^"]*"/g, "")) ? `(${one})` : one));
  return `//frame[${held.join(all ? " and " : " or ")}]`;
}

function conditionOf(row: Row): string {
  if (row.kind === "frames") {
    const [least, most] = [Math.min(row.first, row.last), Math.max(row.first, row.last)];
    return Number.isFinite(least + most) ? `position() >= ${least} and position() <= ${most}` : "";
  }
  if (row.kind === "name") {
    if (!row.name) return "";
    if (row.is === "contains") return `motion_name[contains(., ${literal(row.name)})]`;
    return row.is === "is" ? `motion_name = ${literal(row.name)}` : `not(motion_name = ${literal(row.name)})`;
  }
  if (!row.bone || !Number.isFinite(row.value)) return "";
  return `frame_bone[@name = ${literal(row.bone)}]/@${row.channel} ${row.than} ${row.value}`;
}
