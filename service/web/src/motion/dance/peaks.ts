/** The outline of a sound: (least, most) of each of so many equal stretches. */
import { numberAt } from "../../lists";
export function peaksOf(samples: Float32Array, count: number): Float32Array {
  const found = new Float32Array(count * 2);
  for (let at = 0; at < count; at++) {
    const end = Math.floor(((at + 1) * samples.length) / count);
    let [least, most] = [0, 0];
    for (let place = Math.floor((at * samples.length) / count); place < end; place++) {
      const value = numberAt(samples, place);
      if (value < least) least = value;
      else if (value > most) most = value;
    }
    found[at * 2] = least;
    found[at * 2 + 1] = most;
  }
  return found;
}
