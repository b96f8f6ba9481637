/** What a person corrected for the next fit of a model: phase times, clips left out, values. Kept in this window. */
import { computed, signal } from "@preact/signals";
import { refuse } from "../../state/session/notes";
import type { Model, Row } from "./model";

export interface Times {
  t1: number;
  t2: number;
  end: number;
}
interface Draft {
  times: Record<string, Times>;
  left: string[];
  edited: Record<string, Record<string, string>>;
}

export class Corrections {
  readonly draft;
  readonly count;
  /** Steps that can be taken back, the newest last. */
  readonly steps = signal<{ before: Draft; revert?: () => Promise<void> }[]>([]);
  private readonly key: string;
  private readonly first: Draft;
  private gesture = "";

  constructor(readonly model: Model) {
    this.key = `mcml.reach.${model.id}`;
    this.first = { times: (model.result.parameters.times ?? {}) as Draft["times"], left: [], edited: {} };
    const kept = sessionStorage.getItem(this.key);
    this.draft = signal<Draft>(kept ? (JSON.parse(kept) as Draft) : this.first);
    this.count = computed(() => {
      const { times, left, edited } = this.draft.value;
      const ids = new Set([...Object.keys(times), ...Object.keys(this.first.times)]);
      const moved = [...ids].filter((id) => JSON.stringify(times[id]) !== JSON.stringify(this.first.times[id])).length;
      return moved + left.length + Object.values(edited).reduce((sum, one) => sum + Object.keys(one).length, 0);
    });
  }

  /** The times of a clip as they shall be: a person's, else those that were found. */
  timesOf(row: Row): Times | null {
    const given = this.draft.value.times[row.document];
    if (given) return given;
    return row.t1_frames === null ? null : { t1: row.t1_frames, t2: row.t2_frames!, end: row.end_frames! };
  }

  isSet(document: string): boolean {
    return JSON.stringify(this.draft.value.times[document]) !== JSON.stringify(this.first.times[document]);
  }

  /** gesture: what belongs to one step of undo, such as one drag. */
  setTimes(document: string, times: Times | null, gesture = ""): void {
    const all = { ...this.draft.peek().times };
    const found = times ?? this.first.times[document];
    if (found) all[document] = found;
    else delete all[document];
    this.change({ ...this.draft.peek(), times: all }, undefined, gesture && `${document} ${gesture}`);
  }

  leave(documents: string[], out: boolean): void {
    const left = new Set(this.draft.peek().left);
    for (const one of documents)
      if (out) left.add(one);
      else left.delete(one);
    this.change({ ...this.draft.peek(), left: [...left] });
  }

  /** Values that were written into documents, by document and name. revert: writes those before. */
  edit(edits: Draft["edited"], revert: () => Promise<void>): void {
    const edited = { ...this.draft.peek().edited };
    for (const [document, values] of Object.entries(edits)) edited[document] = { ...edited[document], ...values };
    this.change({ ...this.draft.peek(), edited }, revert);
  }

  undo(): void {
    const step = this.steps.peek().at(-1);
    if (!step) return;
    this.steps.value = this.steps.peek().slice(0, -1);
    this.gesture = "";
    this.keep(step.before);
    void step.revert?.().catch(refuse);
  }

  /** What a fit is asked for: the clips, and the parameters of this model with the times that people set. */
  get request(): { inputs: { documents: string[] }; parameters: Record<string, unknown> } {
    const { times, left } = this.draft.peek();
    const documents = this.model.rows.map((one) => one.document).filter((id) => !left.includes(id));
    const given = Object.fromEntries(Object.entries(times).filter(([id]) => documents.includes(id)));
    return { inputs: { documents }, parameters: { ...this.model.result.parameters, times: given } };
  }

  private change(next: Draft, revert?: () => Promise<void>, gesture = ""): void {
    if (!gesture || gesture !== this.gesture)
      this.steps.value = [...this.steps.peek(), { before: this.draft.peek(), revert }].slice(-200);
    this.gesture = gesture;
    this.keep(next);
  }

  private keep(next: Draft): void {
    this.draft.value = next;
    sessionStorage.setItem(this.key, JSON.stringify(next));
  }
}

export const LEAST_PHASE = 0.5; // frames

/** Times after one of them was moved: in order, half a frame apart, within the clip. */
export function moved(times: Times, which: keyof Times, to: number, last: number): Times {
  const tenth = Math.round(to * 10) / 10;
  const low = { t1: LEAST_PHASE, t2: times.t1 + LEAST_PHASE, end: times.t2 + LEAST_PHASE }[which];
  const high = { t1: times.t2 - LEAST_PHASE, t2: times.end - LEAST_PHASE, end: last }[which];
  return { ...times, [which]: Math.max(low, Math.min(high, tenth)) };
}
