/**
 * What is changed and not saved yet: values, never written over, so that undo is a step back to the one before.
 *
 * Frames are positions from 1, as the repository counts them.
 */
import { itemAt } from "../../lists";
import type { Schemas } from "../../api/client";
import { changedWithin, namesWithin, sampleWithin } from "./fragment";

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
  /** It shall go. */
  deleted?: true;
  /** Elements, as XML, that shall stand beside it, or in it at its end. */
  added?: readonly Addition[];
}

export interface Addition {
  where: "before" | "after" | "into";
  fragment: string;
}

/** A change of something that a text of the same draft has replaced, or that the draft takes away: it would be lost. */
export class Replaced extends RangeError {}

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

/** The change that replaces an element or one above it, and the steps from there to it. */
export function replacedBy(draft: Draft, address: string): { owner: ElementChange; steps: string } | null {
  for (let end = address.length; end > 0; end = address.lastIndexOf("/", end - 1)) {
    const owner = draft.elements.get(address.slice(0, end));
    if (owner?.fragment !== undefined || owner?.deleted) return { owner, steps: address.slice(end + 1) };
  }
  return null;
}

const set = (elements: Draft["elements"], change: ElementChange) => new Map(elements).set(change.address, change);

function rewritten(elements: Draft["elements"], owner: ElementChange, fragment: string | null): Draft["elements"] {
  if (fragment === null) throw new Replaced(owner.address);
  return set(elements, { ...owner, fragment });
}

const frameText = (draft: Draft, frame: number): ElementChange | undefined => {
  const found = draft.elements.get(`/mcml/motion/frame[${frame}]`);
  return found?.fragment === undefined ? undefined : found;
};

/** Set samples of one track. Those of a frame that is a text now are set in it, for the text comes last. */
export function withSamples(draft: Draft, track: string, values: Iterable<readonly [number, number]>): Draft {
  const changed = new Map(draft.samples.get(track));
  const at = track.lastIndexOf(".");
  let { elements } = draft;
  for (const [frame, value] of values) {
    const text = frameText(draft, frame);
    if (text)
      elements = rewritten(
        elements,
        text,
        sampleWithin(text.fragment!, track.slice(0, at), track.slice(at + 1), value),
      );
    else changed.set(frame, value);
  }
  const samples = changed.size ? new Map(draft.samples).set(track, changed) : draft.samples;
  return { ...draft, samples, elements, steps: draft.steps + 1 };
}

/** Name stretches. before: the names as they were, for frames that are texts now. */
export function withLabels(draft: Draft, labels: readonly Span[], before: readonly Span[] = draft.labels ?? []): Draft {
  let { elements } = draft;
  for (const one of draft.elements.values()) {
    const frame = one.fragment === undefined ? null : /^\/mcml\/motion\/frame\[(\d+)\]$/.exec(one.address);
    if (!frame) continue;
    const names = (spans: readonly Span[]) =>
      spans.filter((span) => span.first <= Number(frame[1]) && span.last >= Number(frame[1])).map((span) => span.name);
    const [old, now] = [names(before), names(labels)];
    const [gone, come] = [old.filter((name) => !now.includes(name)), now.filter((name) => !old.includes(name))];
    if (gone.length || come.length) elements = rewritten(elements, one, namesWithin(one.fragment!, gone, come));
  }
  return { ...draft, labels, elements, steps: draft.steps + 1 };
}

/** Change an element; within what a text has replaced, in that text. Replaced where that has no such element. */
export function withElement(draft: Draft, change: ElementChange): Draft {
  const inside = replacedBy(draft, change.address);
  const steps = draft.steps + 1;
  if (inside && change.fragment === undefined) {
    const { owner } = inside;
    if (owner.fragment === undefined) throw new Replaced(owner.address);
    return {
      ...draft,
      elements: rewritten(draft.elements, owner, changedWithin(owner.fragment, inside.steps, change)),
      steps,
    };
  }
  const before = draft.elements.get(change.address);
  return {
    ...draft,
    elements: set(draft.elements, {
      ...before,
      ...change,
      attributes: { ...before?.attributes, ...change.attributes },
    }),
    steps,
  };
}

/** Take an element away, and all that was changed within it; once more: let it stay. */
export function withDeleted(draft: Draft, address: string): Draft {
  const elements = new Map([...draft.elements].filter(([other]) => !other.startsWith(`${address}/`)));
  const before = elements.get(address);
  // What was put beside it stays there.
  const beside = before?.added?.filter((one) => one.where !== "into") ?? [];
  const added = beside.length ? { added: beside } : {};
  if (!before?.deleted) {
    if (replacedBy(draft, address)) throw new Replaced(address);
    elements.set(address, { address, attributes: {}, deleted: true, ...added });
  } else if (beside.length) elements.set(address, { address, attributes: {}, ...added });
  else elements.delete(address);
  return { ...draft, elements, steps: draft.steps + 1 };
}

/** Put elements beside one, or into it. */
export function withAdded(draft: Draft, address: string, addition: Addition): Draft {
  if (replacedBy(draft, address)) throw new Replaced(address);
  const before = draft.elements.get(address) ?? { address, attributes: {} };
  return {
    ...draft,
    elements: set(draft.elements, { ...before, added: [...(before.added ?? []), addition] }),
    steps: draft.steps + 1,
  };
}

/** Take back what was put beside an element or into it: the addition at a place of its list. */
export function withoutAdded(draft: Draft, address: string, place: number): Draft {
  const before = draft.elements.get(address);
  const added = before?.added?.filter((_, at) => at !== place) ?? [];
  const elements = new Map(draft.elements);
  if (before && (added.length || before.deleted || before.text !== undefined || Object.keys(before.attributes).length))
    elements.set(address, { ...before, added });
  else elements.delete(address);
  return { ...draft, elements, steps: draft.steps + 1 };
}

/** Put another text in the place of an element: what was changed within it before goes, for the text says it all. */
export function withFragment(draft: Draft, address: string, fragment: string, frame: number | null): Draft {
  const elements = new Map([...draft.elements].filter(([other]) => !other.startsWith(`${address}/`)));
  elements.set(address, { address, attributes: {}, fragment });
  if (frame === null) return { ...draft, elements };
  const samples = new Map(
    [...draft.samples]
      .map(([track, values]) => [track, new Map([...values].filter(([at]) => at !== frame))] as const)
      .filter(([, values]) => values.size),
  );
  return { ...draft, elements, samples };
}

/** What is made; null where a text of the draft has replaced what would be changed. */
export function orReplaced<T>(make: () => T): T | null {
  try {
    return make();
  } catch (error) {
    if (error instanceof Replaced) return null;
    throw error;
  }
}

/** A draft without what conflicts: theirs stays. */
export function without(draft: Draft, conflicts: readonly Schemas["Conflict"][]): Draft {
  const samples = new Map(draft.samples);
  const elements = new Map(draft.elements);
  let labels = draft.labels;
  for (const { kind, address, first, last } of conflicts) {
    if (kind === "label") labels = null;
    else if (kind === "frames") {
      const kept = [...(samples.get(address) ?? [])].filter(
        ([frame]) => frame < (first ?? 0) || frame > (last ?? Infinity),
      );
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
    for (let at = 0; at < sorted.length;) {
      const first = itemAt(sorted, at)[0];
      const values: number[][] = [];
      while (at < sorted.length && itemAt(sorted, at)[0] === first + values.length)
        values.push([itemAt(sorted, at++)[1]]);
      frames.push({ first, columns: [track], values });
    }
  }
  const elements = [...draft.elements.values()].flatMap(editsOf);
  const labels = draft.labels && draft.labels.map(({ name, first, last }) => ({ name, first, last }));
  return { frames, elements, labels, message, many: false, renumber: true };
}

type Edit = NonNullable<Schemas["ChangeSet"]["elements"]>[number];

/** The edits of one element. Those at one address are made in this order, and its address goes on meaning the place: what
 * comes after it is put in from the last on, what comes before it at the very end. */
function editsOf({ address: xpath, attributes, text, fragment, deleted, added = [] }: ElementChange): Edit[] {
  const inserts = (where: Addition["where"]): Edit[] =>
    added.filter((one) => one.where === where).map((one) => ({ do: "insert", xpath, where, fragment: one.fragment }));
  const edits: Edit[] = [];
  if (deleted && added.length) {
    // Beside what goes there is no place: what comes stands in its own.
    return [
      {
        do: "replace",
        xpath,
        fragment: ["before", "after"]
          .flatMap((where) => added.filter((one) => one.where === where).map((one) => one.fragment))
          .join(""),
      },
    ];
  }
  if (deleted) edits.push({ do: "delete", xpath, renumber: true });
  else if (fragment !== undefined) edits.push({ do: "replace", xpath, fragment });
  else if (text !== undefined || Object.keys(attributes).length)
    edits.push({ do: "change", xpath, attributes, text: text ?? null });
  return [...edits, ...inserts("into"), ...inserts("after").reverse(), ...inserts("before").reverse()];
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
