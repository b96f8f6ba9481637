/** Frames in which some point of a clip is known. */
type Overview = { values: Float32Array; step: number } | null;

/** Of a frame that shows nothing, the nearest one known to show something, -1 where none is; null where this one does,
 * or is not known yet. points: of a frame, three numbers each. */
export function nearestSeen(
  positions: Float32Array | null,
  overview: Overview,
  frame: number,
  points: number,
): number | null {
  if (!positions || positions.some(Number.isFinite)) return null;
  const width = points * 3;
  const seen: number[] = [];
  for (let row = 0; overview && width && (row + 1) * width <= overview.values.length; row++)
    if (overview.values.subarray(row * width, (row + 1) * width).some(Number.isFinite)) seen.push(row * overview.step);
  return seen.reduce((best, at) => (best < 0 || Math.abs(at - frame) < Math.abs(best - frame) ? at : best), -1);
}
