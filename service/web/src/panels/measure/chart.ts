/** The geometry of a small plot: scales, paths, and the curve at a point. Pure functions. */

export type Values = readonly (number | null)[];
export interface Box {
  width: number;
  height: number;
  left: number;
  right: number;
  top: number;
  bottom: number;
}
export const BOX: Box = { width: 300, height: 170, left: 44, right: 14, top: 8, bottom: 32 };
const TICKS = 4;
const STEPS = [1, 2, 2.5, 5, 10];

/** The least and the greatest value of curves, a little apart where they are equal. */
export function extentOf(curves: readonly Values[]): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const curve of curves)
    for (const value of curve) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  if (low > high) return [0, 1];
  const pad = (high - low || Math.abs(high) || 1) * 0.05;
  return [low - pad, high + pad];
}

/** Round numbers within an extent, about four. */
export function ticksOf([low, high]: readonly [number, number]): number[] {
  const rough = (high - low) / TICKS;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * (STEPS.find((one) => one * power >= rough * 0.999) ?? 10);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.max(0, Math.floor(high / step) - first + 1) }, (_, at) =>
    Number(((first + at) * step).toPrecision(12)),
  );
}

export const xAt = (box: Box, percent: number): number =>
  box.left + (percent / 100) * (box.width - box.left - box.right);

export const yAt = (box: Box, [low, high]: readonly [number, number], value: number): number =>
  box.height - box.bottom - ((value - low) / (high - low)) * (box.height - box.top - box.bottom);

const point = (box: Box, extent: readonly [number, number], at: number, value: number) =>
  `${xAt(box, at).toFixed(1)} ${yAt(box, extent, value).toFixed(1)}`;

/** The path of a curve, broken where values are missing. */
export function pathOf(box: Box, extent: readonly [number, number], values: Values): string {
  let path = "";
  let drawn = false;
  values.forEach((value, at) => {
    if (value !== null) path += `${drawn ? "L" : "M"}${point(box, extent, at, value)}`;
    drawn = value !== null;
  });
  return path;
}

/** The area of one standard deviation around a mean, in pieces where values are known. */
export function bandPath(box: Box, extent: readonly [number, number], low: Values, high: Values): string {
  let path = "";
  let from = -1;
  for (let at = 0; at <= low.length; at++) {
    const known = typeof low[at] === "number" && typeof high[at] === "number";
    if (known && from < 0) from = at;
    if (known || from < 0) continue;
    const places = Array.from({ length: at - from }, (_, step) => from + step);
    const upper = places.map((place) => point(box, extent, place, high[place] ?? 0));
    const lower = places.reverse().map((place) => point(box, extent, place, low[place] ?? 0));
    path += `M${[...upper, ...lower].join("L")}Z`;
    from = -1;
  }
  return path;
}

/** The curve that is nearest to a point of the plot, -1 where none is near. */
export function nearest(
  box: Box,
  extent: readonly [number, number],
  curves: readonly Values[],
  [x, y]: readonly [number, number],
  within = 14,
): number {
  const percent = Math.round(((x - box.left) / (box.width - box.left - box.right)) * 100);
  let [found, least] = [-1, within];
  curves.forEach((curve, at) => {
    const value = curve[Math.max(0, Math.min(100, percent))];
    if (typeof value !== "number") return;
    const away = Math.abs(yAt(box, extent, value) - y);
    if (away < least) [found, least] = [at, away];
  });
  return found;
}
