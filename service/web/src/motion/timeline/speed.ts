/** How fast points move, for the curve under a timeline. */
import { numberAt } from "../../lists";
const known = new WeakMap<object, { of: Float32Array; speeds: Float32Array }>();

/** Mean distance of all points from each row to the next: (rows,). values: (rows, points, 3). Kept for `owner`. */
export function speedOf(owner: object, values: Float32Array, points: number): Float32Array {
  const before = known.get(owner);
  if (before?.of === values) return before.speeds;
  const stride = points * 3;
  const rows = values.length / stride;
  const speeds = new Float32Array(rows);
  for (let row = 0; row + 1 < rows; row++) {
    let sum = 0;
    let count = 0;
    for (let at = row * stride; at < (row + 1) * stride; at += 3) {
      const away = Math.hypot(
        numberAt(values, at + stride) - numberAt(values, at),
        numberAt(values, at + stride + 1) - numberAt(values, at + 1),
        numberAt(values, at + stride + 2) - numberAt(values, at + 2),
      );
      if (away === away) {
        sum += away;
        count++;
      }
    }
    speeds[row] = count ? sum / count : 0;
  }
  if (rows > 1) speeds[rows - 1] = numberAt(speeds, rows - 2);
  known.set(owner, { of: values, speeds });
  return speeds;
}
