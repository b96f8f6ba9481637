/** Random numbers with a seed, for tests: the same each time. */
export interface Random {
  /** From 0 to 1. */
  (): number;
  /** A whole number from `least` to `most`, both included. */
  whole: (least: number, most: number) => number;
}

/** mulberry32. */
export function random(seed: number): Random {
  let state = seed >>> 0;
  const next = () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
  return Object.assign(next, {
    whole: (least: number, most: number) => least + Math.floor(next() * (most - least + 1)),
  });
}
