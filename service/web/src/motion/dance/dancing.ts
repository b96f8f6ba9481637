/** Beats of a clip as a person corrects them, and what may be danced where. Seconds from the first frame. */

export type BeatKind = "detected" | "tracked" | "hand";
export interface Beat {
  at: number;
  kind: BeatKind;
}

const SAME = 0.02; // seconds within which two beats are one

/** The minimum of the speed nearest to a moment, where one is near enough; else the moment. */
export function snapped(at: number, minima: readonly number[], within: number): number {
  let best = at;
  let least = within;
  for (const one of minima) {
    const away = Math.abs(one - at);
    if (away <= least) [best, least] = [one, away];
  }
  return best;
}

const ordered = (beats: readonly Beat[]): Beat[] => [...beats].sort((a, b) => a.at - b.at);

/** Beats with one more, set by hand; one that is there already becomes so. */
export const withBeat = (beats: readonly Beat[], at: number): Beat[] =>
  ordered([...beats.filter((one) => Math.abs(one.at - at) > SAME), { at: Math.max(0, at), kind: "hand" }]);

export const withoutBeat = (beats: readonly Beat[], index: number): Beat[] => beats.filter((_, at) => at !== index);

export const movedBeat = (beats: readonly Beat[], index: number, at: number): Beat[] =>
  withBeat(withoutBeat(beats, index), at);

/** All tracked beats as a person's own: later runs do not lose them. */
export const accepted = (beats: readonly Beat[]): Beat[] =>
  beats.map((one) => (one.kind === "tracked" ? { ...one, kind: "hand" } : one));

/** The beat nearest to a moment; -1 where none is near enough. */
export function nearestBeat(beats: readonly Beat[], at: number, within: number): number {
  let [best, least] = [-1, within];
  beats.forEach((one, index) => {
    const away = Math.abs(one.at - at);
    if (away <= least) [best, least] = [index, away];
  });
  return best;
}

/** Bars that may stand at positions of a dance, both from 1. */
export type Allowed = ReadonlyMap<number, readonly number[]>;

/** "4:3.7,5:2" as written in an address. What is no such thing is left out. */
export function readAllowed(text: string): Map<number, number[]> {
  const found = new Map<number, number[]>();
  for (const part of text.split(",")) {
    const [position, bars] = part.split(":");
    const numbers = (bars ?? "")
      .split(".")
      .map(Number)
      .filter((one) => Number.isInteger(one) && one > 0);
    if (Number.isInteger(Number(position)) && Number(position) > 0 && numbers.length)
      found.set(Number(position), numbers);
  }
  return found;
}

export const writeAllowed = (allowed: Allowed): string =>
  [...allowed]
    .filter(([, bars]) => bars.length)
    .sort(([a], [b]) => a - b)
    .map(([position, bars]) => `${position}:${bars.join(".")}`)
    .join(",");

/** A bar allowed at a position, or no longer. */
export function toggled(allowed: Allowed, position: number, bar: number): Map<number, number[]> {
  const before = allowed.get(position) ?? [];
  const next = new Map<number, number[]>([...allowed].map(([key, bars]) => [key, [...bars]]));
  const bars = before.includes(bar) ? before.filter((one) => one !== bar) : [...before, bar];
  if (bars.length) next.set(position, bars);
  else next.delete(position);
  return next;
}
