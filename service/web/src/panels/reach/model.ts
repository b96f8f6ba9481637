/** A fitted model as its page shows it: clips, attributes, errors, and what it says of itself. */
import { partOf, rowsOf, type Result } from "../../api/results";
import type { Moments } from "../../motion/timeline/phases";

export interface Row {
  document: string;
  revision: number;
  name: string;
  subject: string | null;
  used: boolean;
  reason: string | null;
  why: string | null;
  t1_seconds: number | null;
  t2_seconds: number | null;
  end_seconds: number | null;
  t1_frames: number | null;
  t2_frames: number | null;
  end_frames: number | null;
  fps: number;
  peak_speed: number | null;
  flags: string[];
  [attribute: string]: unknown;
}

export interface Attribute {
  name: string;
  unit: string;
  mean: number;
  deviation: number;
  least: number;
  greatest: number;
  gaps: [number, number][];
  values: number[];
}
export interface LeftOut {
  left_out: string;
  predictor: string;
  joint_degrees: number | null;
  phase_joint_degrees: number | null;
  hand: number | null;
  times: Record<string, number | null>;
  clips: number;
}

export interface Summary {
  method: string;
  space: string;
  attribute_space: string;
  used: number;
  excluded: number;
  examples: number;
  subjects: number;
  joints: number;
  phase_joint: string;
  hand_joint: string;
  components: number;
  variance: number | null;
  pose_variance: number | null;
  s: number;
  lam: number;
  time_s: number;
  time_lam: number;
  hand_unit: string;
  reconstruction: { joint_degrees: number | null; phase_joint_degrees: number | null; hand: number | null };
  left_out: LeftOut[];
  attributes: Omit<Attribute, "values">[];
  warnings: { code: string; what: string }[];
}

export interface Model {
  id: string;
  result: Result;
  summary: Summary;
  rows: Row[];
  used: Row[];
  byId: Map<string, Row>;
  attributes: Attribute[];
}

export function modelOf(result: Result): Model {
  const summary = partOf(result, "model").data.summary as Summary;
  const rows = rowsOf<Row>(result.parts.clips);
  const used = rows.filter((one) => one.used);
  const attributes = summary.attributes.map((one) => ({ ...one, values: used.map((row) => row[one.name] as number) }));
  return {
    id: result.id,
    result,
    summary,
    rows,
    used,
    byId: new Map(rows.map((one) => [one.document, one])),
    attributes,
  };
}

export const momentsOf = (row: Row): Moments | null =>
  row.t1_frames === null ? null : [0, row.t1_frames, row.t2_frames!, row.end_frames!];

/** How far off the model is for what it has not seen: people where they are told apart, else clips. */
export const unseenOf = ({ summary }: Model): LeftOut | undefined =>
  summary.left_out.findLast((one) => one.predictor === "model");

export type Values = Record<string, number>;

/** The values of the example that is most in the middle: there the page begins. */
export function middleOf(model: Model): Values {
  const away = (row: Row) =>
    model.attributes.reduce(
      (sum, one) => sum + (((row[one.name] as number) - one.mean) / (one.deviation || 1)) ** 2,
      0,
    );
  const best = model.used.reduce((least, row) => (away(row) < away(least) ? row : least));
  return valuesOf(model, best);
}

export const valuesOf = (model: Model, row: Row): Values =>
  Object.fromEntries(model.attributes.map((one) => [one.name, row[one.name] as number]));

const RESERVED = ["tab", "near", "pad", "clip", "project", "v"];

/** The name of an attribute in the address. */
export const paramOf = (name: string): string => (RESERVED.includes(name) ? `a.${name}` : name);

const ROOM = 0.12;

/** The ends of an attribute's slider: the examples' and some room to both sides. */
export function endsOf({ least, greatest }: Attribute): [number, number] {
  const room = (greatest - least || Math.abs(greatest) || 1) * ROOM;
  return [Math.max(least - room, least >= 0 ? 0 : -Infinity), greatest + room];
}

export type Support = "inside" | "gap" | "outside";

/** What one attribute says of a value alone. */
export function supportOf({ least, greatest, gaps }: Attribute, value: number): Support {
  if (value < least || value > greatest) return "outside";
  return gaps.some(([low, high]) => low < value && value < high) ? "gap" : "inside";
}
