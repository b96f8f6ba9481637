/** What the address says is measured, and the request that asks it. Pure functions. */
import type { Schemas } from "../../api/client";
import type { Selection } from "../../ui/clips/ClipSelection";

export type Measures = Schemas["Measures"];
export type Row = Schemas["MeasuredRange"];
export type Group = Schemas["MeasuredGroup"];

/** ranges: "" whole clips, "strides", "query", or "label:NAME". by: a key besides the side, "" for none. */
export interface Asked {
  quantities: string[];
  ranges: string;
  query: string;
  by: string;
}

const BETWEEN = "|";
const LABEL = "label:";
const SIDE = "side";
export const MOST_ROWS = 1000;

export const readAsked = (param: (name: string) => string): Asked => ({
  quantities: param("m").split(BETWEEN).filter(Boolean),
  ranges: param("ranges"),
  query: param("q"),
  by: param("by"),
});

/** The parameters of the address for measurements. */
export const writeQuantities = (quantities: readonly string[]): string | null =>
  [...new Set(quantities)].join(BETWEEN) || null;

/** The request, null while nothing can be measured. */
export function requestOf(selection: Selection | null, asked: Asked) {
  const isQuery = asked.ranges === "query";
  if (!asked.quantities.length || (isQuery ? !asked.query.trim() : !selection)) return null;
  return {
    // The clips that the list shows, also those that analyses made.
    selection: selection ? { documents: [], property: [], ...selection, include_made: true } : undefined,
    quantities: asked.quantities,
    query: isQuery ? asked.query : undefined,
    cycles: asked.ranges.startsWith(LABEL) ? [asked.ranges.slice(LABEL.length)] : [],
    strides: asked.ranges === "strides",
    by: asked.by ? [SIDE, asked.by] : [SIDE],
  };
}

/** The measurements of both sides: of left the right too, and the other way round. */
export function bothSides(quantity: string): string[] {
  const swap: Record<string, string> = { left: "right", right: "left" };
  const other = quantity.replace(/\b(left|right)(?=[_-])/g, (side) => swap[side] ?? side);
  if (other === quantity) return [quantity];
  return quantity.includes("left") ? [quantity, other] : [other, quantity];
}

export const GAIT = ["hip-flexion", "knee-flexion", "ankle-dorsiflexion"].flatMap((name) =>
  bothSides(`angle:left-${name}`),
);
export const HANDS = bothSides("speed:left_hand");
export const FEET = bothSides("height:left_foot");

/** What tells a row from all others. */
export const keyOf = (row: Pick<Row, "document" | "first" | "last" | "quantity">): string =>
  `${row.document}.${row.first}.${row.last}.${row.quantity}`;

/** The rows of a group, as the answer has them: those farthest from the group first. */
export const rowsOf = (group: Group, rows: readonly Row[]): Row[] =>
  rows.filter(
    (row) =>
      row.quantity === group.quantity && Object.entries(group.group).every(([key, value]) => row.group[key] === value),
  );
