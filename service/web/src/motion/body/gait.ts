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
interface Summary {
  mean: number | null;
  sd: number | null;
  n: number;
}
interface Parameter {
  name: string;
  unit: string;
  left: Summary;
  right: Summary;
  symmetry: number | null;
}

const PARTS = ["Pelvis", "Hip", "Knee", "Ankle"];
const OF_SKELETON = ["leg-flexion", "knee-flexion", "foot-dorsiflexion"];

/** Angles of the laboratory's own model where the file has them, else those of the skeleton; markers alone have none. */
export function pairsOf(measured: readonly Measured[], axis: string, markers: boolean): Pair[] {
  const names = measured.filter((each) => each.function === "quantity").map((each) => each.name);
  const own = PARTS.flatMap((part) => {
    const left = names.find((name) => (name.split(":").pop() ?? "") === `L${part}Angles`);
    const right = left?.replace(/L(\w+)$/, "R$1");
    return left && right && names.includes(right)
      ? [{ title: part, left: `quantity:${left},${axis}`, right: `quantity:${right},${axis}` }]
      : [];
  });
  if (own.length || markers) return own;
  return OF_SKELETON.map((name) => ({ title: name, left: `angle:left-${name}`, right: `angle:right-${name}` }));
}

/** Lines of mean and standard deviation for every percent of the cycle. */
export const bandOf = ({ mean, sd }: Cycle, sign: 1 | -1): (number | null)[] =>
  mean.map((value, at) => {
    const wide = sd[at];
    return value === null || wide === null || wide === undefined ? null : value + sign * wide;
  });

const cell = (value: number | string | null): string => (value === null ? "" : String(value));

/** Parameters, then cycles, in long form. */
export function csvOf(parameters: readonly Parameter[], cycles: readonly Cycle[]): string {
  const rows: (number | string | null)[][] = [["name", "side", "percent", "mean", "sd", "n", "unit"]];
  for (const { name, unit, left, right } of parameters)
    for (const [side, { mean, sd, n }] of [
      ["left", left],
      ["right", right],
    ] as const)
      rows.push([name, side, null, mean, sd, n, unit]);
  for (const { quantity, side, unit, mean, sd } of cycles)
    mean.forEach((value, percent) => rows.push([quantity, side, percent, value, sd[percent] ?? null, null, unit]));
  return rows.map((row) => row.map((value) => quoted(cell(value))).join(",")).join("\r\n") + "\r\n";
}

// A text that begins like a formula gets a quote, as in other CSV of the service.
const quoted = (text: string): string => {
  const safe = /^[=+@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
};
