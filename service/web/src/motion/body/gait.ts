/** Gait of a clip: the curves that are shown, and the table that leaves as CSV. Pure functions. */
import type { Measured } from "./quantities";

/** A curve of both sides, as the service asks for it. */
export interface Pair {
  title: string;
  left: string;
  right: string;
}
interface Cycle {
  quantity: string;
  side: "left" | "right";
  unit: string;
  mean: (number | null)[];
  sd: (number | null)[];
}
const PARTS = ["Pelvis", "Hip", "Knee", "Ankle"];
const OF_SKELETON = ["hip-flexion", "knee-flexion", "ankle-dorsiflexion"];

/** stated: the laboratory's own angles where the file has them. computed: those of the model that is computed beside. */
export type Model = "stated" | "computed";
const COMPUTED = /(^|:)cgm1:/;

const namesOf = (measured: readonly Measured[]): string[] =>
  measured.filter((each) => each.function === "quantity" && !each.reason).map((each) => each.name);

/** Whether angles of the laboratory and computed ones are there. */
export const hasBothModels = (measured: readonly Measured[]): boolean =>
  namesOf(measured).some((name) => COMPUTED.test(name) && name.endsWith("Angles"));

/** Angles of the laboratory's own model or of a computed one, else those of the skeleton; markers alone have none. */
export function pairsOf(measured: readonly Measured[], axis: string, markers: boolean, model: Model): Pair[] {
  const names = namesOf(measured);
  const own = PARTS.flatMap((part) => {
    const of = names.filter((name) => (name.split(":").pop() ?? "") === `L${part}Angles`);
    const left = of.find((name) => COMPUTED.test(name) === (model === "computed")) ?? of[0];
    const right = left?.replace(/L(\w+)$/, "R$1");
    return left && right && names.includes(right)
      ? [{ title: part, left: `quantity:${left},${axis}`, right: `quantity:${right},${axis}` }]
      : [];
  });
  if (own.length || markers) return own;
  return OF_SKELETON.map((name) => ({ title: name, left: `angle:left-${name}`, right: `angle:right-${name}` }));
}

/** How the angles were computed, "" where the laboratory did it. */
export function howComputed(measured: readonly (Measured & { notes?: string[] })[], pairs: readonly Pair[]): string {
  const names = pairs.map((pair) => pair.left.replace(/^quantity:(.*),\w$/, "$1"));
  const notes = measured.filter((each) => names.includes(each.name)).flatMap((each) => each.notes ?? []);
  return notes.some((note) => note.startsWith("computed by")) ? [...new Set(notes)].join("; ") : "";
}

/** Lines of mean and standard deviation for every percent of the cycle. */
export const bandOf = ({ mean, sd }: Cycle, sign: 1 | -1): (number | null)[] =>
  mean.map((value, at) => {
    const wide = sd[at];
    return value === null || wide === null || wide === undefined ? null : value + sign * wide;
  });

/** The mean of curves of both sides, as normal bands are drawn; null where a side is unknown. */
export function meanOf(cycles: readonly (Cycle & { n: number })[]): Cycle & { n: number } {
  const [first] = cycles;
  if (!first) throw new Error("no cycles");
  const mean = (part: "mean" | "sd") =>
    first.mean.map((_, at) => {
      const values = cycles.map((cycle) => cycle[part][at]).filter((value) => typeof value === "number");
      return values.length < cycles.length ? null : values.reduce((sum, value) => sum + value, 0) / values.length;
    });
  return { ...first, mean: mean("mean"), sd: mean("sd"), n: cycles.reduce((sum, cycle) => sum + cycle.n, 0) };
}
