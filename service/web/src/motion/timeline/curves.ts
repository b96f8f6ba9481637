/** Curves of channels: unwrapped angles, and the tools that change a stretch of one. Pure functions on arrays. */
import { numberAt } from "../../lists";

/** Angles without jumps of a whole turn: (n,). NaN stays. */
export function unwrapped(values: ArrayLike<number>, turn = 360): Float64Array {
  const found = new Float64Array(values.length);
  let shift = 0;
  let before = NaN;
  for (let at = 0; at < values.length; at++) {
    const value = numberAt(values, at);
    if (value === value) {
      if (before === before) shift -= Math.round((value - before) / turn) * turn;
      before = value;
    }
    found[at] = value + shift;
  }
  return found;
}

/** A Gaussian over a stretch: width is its deviation in frames; what lies beyond the ends is as at the ends. Between the
 * ends and half a deviation inside, the old curve comes back, so that no step is made. */
export function smoothed(values: ArrayLike<number>, width: number): Float64Array {
  const count = values.length;
  const reach = Math.max(1, Math.ceil(width * 3));
  const weights = Float64Array.from({ length: 2 * reach + 1 }, (_, at) => Math.exp(-0.5 * ((at - reach) / width) ** 2));
  const found = new Float64Array(count);
  const fade = Math.min(Math.ceil(width), Math.floor((count - 1) / 2));
  for (let at = 0; at < count; at++) {
    let [sum, weight] = [0, 0];
    for (let by = -reach; by <= reach; by++) {
      const value = numberAt(values, Math.max(0, Math.min(count - 1, at + by)));
      if (value !== value) continue;
      sum += numberAt(weights, by + reach) * value;
      weight += numberAt(weights, by + reach);
    }
    const share = fade ? Math.min(1, Math.min(at, count - 1 - at) / fade) : 1;
    const value = weight ? sum / weight : NaN;
    found[at] = values[at] === values[at] ? numberAt(values, at) + share * (value - numberAt(values, at)) : NaN;
  }
  return found;
}

/** Times a factor about the mean. */
export function scaled(values: ArrayLike<number>, factor: number): Float64Array {
  let [sum, count] = [0, 0];
  for (let at = 0; at < values.length; at++)
    if (values[at] === values[at]) {
      sum += numberAt(values, at);
      count++;
    }
  const mean = count ? sum / count : 0;
  return Float64Array.from({ length: values.length }, (_, at) => mean + (numberAt(values, at) - mean) * factor);
}

export const shifted = (values: ArrayLike<number>, by: number): Float64Array =>
  Float64Array.from({ length: values.length }, (_, at) => numberAt(values, at) + by);
