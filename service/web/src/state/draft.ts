/**
 * What is changed and not saved yet: values, never written over, so that undo is a step back to the one before.
 *
 * Frames are positions from 1, as the repository counts them.
 */
import type { Schemas } from "../api/client";

export interface Span {
  /** Of the repository's label; negative for one that is not stored yet. */
  id: number;
  name: string;
  first: number;
  last: number;
}

export interface ElementChange {
  address: string;
  attributes: Record<string, string | null>;
  text?: string;
  /** Other elements, as XML, in its place. */
  fragment?: string;
}

export interface Draft {
  /** Samples by track, "Root.Tx", and frame. */
  samples: ReadonlyMap<string, ReadonlyMap<number, number>>;
  /** All labels as they shall be; null: as stored. */
  labels: readonly Span[] | null;
  /** Attributes and texts of elements, by address. */
  elements: ReadonlyMap<string, ElementChange>;
  /** How many things were done. */
  steps: number;
}

export const EMPTY: Draft = { samples: new Map(), labels: null, elements: new Map(), steps: 0 };

export const isEmpty = (draft: Draft): boolean => !draft.samples.size && !draft.labels && !draft.elements.size;

/** Set samples of one track. */
export function withSamples(draft: Draft, track: string, values: Iterable<readonly [number, number]>): Draft {
  const changed = new Map(draft.samples.get(track));
  for (const [frame, value] of values) changed.set(frame, value);
  return { ...draft, samples: new Map(draft.samples).set(track, changed), steps: draft.steps + 1 };
}

export const withLabels = (draft: Draft, labels: readonly Span[]): Draft => ({ ...draft, labels, steps: draft.steps + 1 });

export function withElement(draft: Draft, change: ElementChange): Draft {
  const before = draft.elements.get(change.address);
  const merged = { ...before, ...change, attributes: { ...before?.attributes, ...change.attributes } };
  return { ...draft, elements: new Map(draft.elements).set(change.address, merged), steps: draft.steps + 1 };
}

/** Put another text in the place of an element: what was changed within it before goes, for the text says it all. */
export function withFragment(draft: Draft, address: string, fragment: string, frame: number | null): Draft {
  const elements = new Map([...draft.elements].filter(([other]) => !other.startsWith(`${address}/`)));
  elements.set(address, { address, attributes: {}, fragment });
  if (frame === null) return { ...draft, elements };
  const samples = new Map([...draft.samples].map(([track, values]) => [track, new Map([...values].filter(([at]) => at !== frame))] as const).filter(([, values]) => values.size));
  return { ...draft, elements, samples };
}

/** A draft without what conflicts: theirs stays. */
export function without(draft: Draft, conflicts: readonly Schemas["Conflict"][]): Draft {
  const samples = new Map(draft.samples);
  const elements = new Map(draft.elements);
  let labels = draft.labels;
  for (const { kind, address, first, last } of conflicts) {
    if (kind === "label") labels = null;
    else if (kind === "frames") {
      const kept = [...(samples.get(address) ?? [])].filter(([frame]) => frame < (first ?? 0) || frame > (last ?? Infinity));
      if (kept.length) samples.set(address, new Map(kept));
      else samples.delete(address);
    } else elements.delete(address);
  }
  return { ...draft, samples, elements, labels };
}

/** The frames that some sample of the draft touches: (first, last), or null. */
export function touched(draft: Draft): [number, number] | null {
  let [first, last] = [Infinity, -Infinity];
  for (const track of draft.samples.values()) {
    for (const frame of track.keys()) {
      first = Math.min(first, frame);
      last = Math.max(last, frame);
    }
  }
  return first <= last ? [first, last] : null;
}

/** A draft as the repository takes it: samples as blocks of consecutive frames, labels as they all shall be. */
export function asChanges(draft: Draft, message = ""): Schemas["ChangeSet"] {
  const frames: NonNullable<Schemas["ChangeSet"]["frames"]> = [];
  for (const [track, samples] of draft.samples) {
    const sorted = [...samples].sort((a, b) => a[0] - b[0]);
    for (let at = 0; at < sorted.length; ) {
      const first = sorted[at][0];
      const values: number[][] = [];
      while (at < sorted.length && sorted[at][0] === first + values.length) values.push([sorted[at++][1]]);
      frames.push({ first, columns: [track], values });
    }
  }
  const elements = [...draft.elements.values()].map((one): NonNullable<Schemas["ChangeSet"]["elements"]>[number] =>
    one.fragment === undefined
      ? { do: "change", xpath: one.address, attributes: one.attributes, text: one.text ?? null }
      : { do: "replace", xpath: one.address, fragment: one.fragment },
  );
  const labels = draft.labels && draft.labels.map(({ name, first, last }) => ({ name, first, last }));
  return { frames, elements, labels, message, many: false, renumber: true };
}

/** As text that survives a reload; `revived` reads it. */
export function frozen(draft: Draft, base: number): string {
  return JSON.stringify({
    base,
    steps: draft.steps,
    labels: draft.labels,
    samples: [...draft.samples].map(([track, values]) => [track, [...values]]),
    elements: [...draft.elements.values()],
  });
}

export function revived(text: string): { base: number; draft: Draft } {
  const found = JSON.parse(text) as {
    base: number;
    steps: number;
    labels: Span[] | null;
    samples: [string, [number, number][]][];
    elements: ElementChange[];
  };
  return {
    base: found.base,
    draft: {
      steps: found.steps,
      labels: found.labels,
      samples: new Map(found.samples.map(([track, values]) => [track, new Map(values)])),
      elements: new Map(found.elements.map((one) => [one.address, one])),
    },
  };
}
