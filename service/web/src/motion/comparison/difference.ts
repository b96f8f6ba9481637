/** How far joints are apart in two motions of one skeleton. */
import { numberAt } from "../../lists";
export interface Apart {
  joint: number;
  /** Metres, by row. */
  away: Float32Array;
  most: number;
  /** The row where it is farthest. */
  at: number;
}

export const LEAST = 1e-4; // metres: less is not seen

/** Joints that are farther apart than is seen somewhere, the farthest first. now, then: (rows, points, 3). */
export function apart(now: Float32Array, then: Float32Array, points: number, joints: number, metres: number): Apart[] {
  const rows = Math.min(now.length, then.length) / (points * 3);
  return Array.from({ length: joints }, (_, joint): Apart => {
    const away = new Float32Array(rows);
    let [most, at] = [0, 0];
    for (let row = 0; row < rows; row++) {
      const place = (row * points + joint) * 3;
      away[row] =
        Math.hypot(
          numberAt(now, place) - numberAt(then, place),
          numberAt(now, place + 1) - numberAt(then, place + 1),
          numberAt(now, place + 2) - numberAt(then, place + 2),
        ) * metres || 0;
      if (numberAt(away, row) > most) [most, at] = [numberAt(away, row), row];
    }
    return { joint, away, most, at };
  })
    .filter((one) => one.most > LEAST)
    .sort((a, b) => b.most - a.most);
}
