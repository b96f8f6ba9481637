/** Where edges of spans snap. An edge lies before a frame (from 0): a span over frames 1 to 3 has the edges 0 and 3. */
import { numberAt } from "../../lists";

const STILL_SECONDS = 0.15;
const WIDER = 3; // times that moment: what counts as around it
const DEPTH = 0.06; // of the greatest speed, that a minimum lies below what is around it

/** The mark nearest to an edge; null where none is near enough. within: frames. */
export function nearestMark(edge: number, marks: readonly number[], within: number): number | null {
  let best: number | null = null;
  for (const mark of marks)
    if (Math.abs(mark - edge) <= within && (best === null || Math.abs(mark - edge) < Math.abs(best - edge)))
      best = mark;
  return best;
}

/** Frames at which the body is slowest: least within a moment, and clearly less than around it. speeds: every `step`
 * frames. */
export function stills(speeds: ArrayLike<number>, step: number, perSecond: number): number[] {
  const around = Math.max(1, Math.round((STILL_SECONDS * perSecond) / step));
  let greatest = 0;
  for (let row = 0; row < speeds.length; row++) greatest = Math.max(greatest, numberAt(speeds, row));
  const found: number[] = [];
  const most = (from: number, to: number) => {
    const last = Math.min(speeds.length - 1, to);
    let value = 0;
    for (let row = Math.max(0, from); row <= last; row++) value = Math.max(value, numberAt(speeds, row));
    return value;
  };
  for (let row = around; row + around < speeds.length; row++) {
    let least = true;
    for (let by = 1; by <= around && least; by++)
      least = numberAt(speeds, row - by) > numberAt(speeds, row) && numberAt(speeds, row + by) >= numberAt(speeds, row);
    if (
      least &&
      Math.min(most(row - WIDER * around, row), most(row, row + WIDER * around)) - numberAt(speeds, row) >
        DEPTH * greatest
    )
      found.push(row * step);
  }
  return found;
}
