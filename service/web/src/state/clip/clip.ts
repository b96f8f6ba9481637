/**
 * The clip that is open: its document, skeleton and frames, and what is selected, looked at and changed in it. Tree,
 * graph, text, timeline and viewer are views of these signals; none keeps a copy.
 */
import { numberAt } from "../../lists";
import { batch, computed, effect, signal, type ReadonlySignal } from "@preact/signals";
import { ask, get, type Schemas } from "../../api/client";
import { Blocks, channelsOf, positionsOf, rotationsOf } from "../../motion/loading/blocks";
import { columnsOf, posed } from "../../motion/body/kinematics";
import type { Vector } from "../../motion/body/quaternions";
import { reshaped, textsOf } from "../../motion/body/shape";
import { skeletonOf, type Skeleton } from "../../motion/body/skeleton";
import { w } from "../../words";
import { compareRevisions, type Compared } from "./compared";
import { compareProposal } from "./proposed";
import { terms } from "./review";
import * as drafts from "../editing/draft";
import type { Draft, Span } from "../editing/draft";
import { note, refuse } from "../session/notes";
import { Player } from "./player";

export type Detail = Schemas["DocumentDetail"];
const USUAL_RATE = 30; // frames a second, where nobody stated one
const REDO_STEPS = 200;

/** What was selected: joints, and an element of the document by its address. */
export interface Selection {
  bones: readonly string[];
  channel: string | null;
}

export class Clip {
  readonly selection = signal<Selection>({ bones: [], channel: null });
  readonly draft = signal<Draft>(drafts.EMPTY);
  readonly saving = signal(false);
  /** What could not be saved, until it is looked at. */
  readonly trouble = signal<unknown>(null);
  readonly labels = computed<readonly Span[]>(() => this.draft.value.labels ?? this.stored);
  readonly changed = computed(() => !drafts.isEmpty(this.draft.value));
  readonly skeleton: Skeleton;
  /** The skeleton with the bones as the draft has them. */
  readonly shape: ReadonlySignal<Skeleton>;
  readonly player: Player;
  readonly blocks: Blocks;
  readonly channels: Blocks<Float64Array>;
  /** Rotations of the joints, fetched while `turning`: bodies with a skin need them. */
  readonly rotations: Blocks;
  readonly turning = signal(false);
  readonly columns: Map<string, number>;
  private readonly stored: readonly Span[];
  /** The revision that the draft was begun on: what it is saved for. */
  private base: number;
  private done: Draft[] = [];
  private undone: Draft[] = [];
  private readonly stops: (() => void)[] = [];
  /** A revision that is shown as a ghost beside this one. */
  readonly compared = signal<Compared | null>(null);
  private comparing: AbortController | null = null;
  /** Whether the old pose stands in the place of the new one, while a key is held. */
  readonly flipped = signal(false);

  constructor(
    readonly detail: Detail,
    view: Schemas["SkeletonView"],
    /** null: the newest, which can be edited. */
    readonly pinned: number | null,
  ) {
    this.skeleton = skeletonOf(view);
    this.shape = computed(() => reshaped(this.skeleton, this.draft.value.elements));
    this.player = new Player(view.frames, 1 / (view.seconds_per_frame || 1 / USUAL_RATE));
    this.blocks = new Blocks(positionsOf(detail.id, detail.revision, this.skeleton));
    this.channels = new Blocks(channelsOf(detail.id, detail.revision, this.skeleton));
    this.rotations = new Blocks(rotationsOf(detail.id, detail.revision, this.skeleton));
    this.columns = columnsOf(view);
    this.base = detail.revision;
    this.stored = detail.labels.map(({ id, name, first, last }) => ({ id, name, first, last }));
    if (pinned === null) this.revive();
    this.stops.push(
      effect(() => this.keep(this.draft.value)),
      effect(() => {
        const { player } = this;
        const frame = player.frame.value;
        const direction = player.playing.value ? Math.sign(player.speed.value) : 0;
        const pace = player.perSecond * Math.abs(player.speed.peek());
        this.blocks.want(frame, direction, pace, player.range[0]);
        if (this.turning.value) this.rotations.want(frame, direction, pace, player.range[0]);
        const other = this.compared.value;
        const place = other?.at(frame) ?? null;
        if (place !== null) other!.blocks.want(place, direction, player.perSecond, other!.at(player.range[0]) ?? place);
        const there = drafts.touched(this.draft.value);
        if (this.shape.value !== this.skeleton) this.channels.want(frame, direction, player.perSecond, player.range[0]);
        else if (there && frame + 1 >= there[0] && frame + 1 <= there[1]) this.channels.want(frame);
      }),
    );
  }

  get id(): string {
    return this.detail.id;
  }

  get frames(): number {
    return this.detail.frames;
  }

  /** Joints' and tips' positions at a frame (from 0), as they will be when the draft is saved. asks: channels that the
   * draft needs and that are not there are fetched; of many frames only the one that is looked at asks. */
  positions(frame: number, asks = true): Float32Array | null {
    const values = this.drafted(frame, asks);
    return values ? posed(this.shape.value, this.columns, values) : this.blocks.frame(frame);
  }

  /** Rotations of the joints at the same frame, (joints, 4) from rest; null while they or the positions are on their
   * way. */
  turns(frame: number, asks = true): Float32Array | null {
    const values = this.drafted(frame, asks);
    if (values) {
      const found = new Float32Array(this.skeleton.view.bones.length * 4);
      posed(this.shape.value, this.columns, values, found);
      return found;
    }
    return this.rotations.has(frame) && this.blocks.has(frame) ? this.rotations.frame(frame) : null;
  }

  /** The channels of a frame that the draft changes, as it has them; null: they are as stored, or on their way. */
  private drafted(frame: number, asks: boolean): Float64Array | null {
    const changes = [...this.draft.value.samples].filter(([, values]) => values.has(frame + 1));
    if (!changes.length && this.shape.value === this.skeleton) return null;
    const stored = this.channels.has(frame) ? this.channels.frame(frame) : null;
    if (!stored) {
      if (asks) this.channels.want(frame);
      return null;
    }
    const values = Float64Array.from(stored);
    for (const [track, samples] of changes) values[this.columns.get(track)!] = samples.get(frame + 1)!;
    return values;
  }

  /** A sample as the draft has it, else as stored; null while it is on its way. */
  sample(track: string, frame: number): number | null {
    const changed = this.draft.value.samples.get(track)?.get(frame + 1);
    if (changed !== undefined) return changed;
    if (!this.channels.has(frame)) return null;
    const column = this.columns.get(track);
    return column === undefined ? null : numberAt(this.channels.frame(frame)!, column);
  }

  select(bones: readonly string[], channel: string | null = null): void {
    this.selection.value = { bones, channel };
  }

  // Changes

  /** Do something that can be undone. */
  change(next: Draft): void {
    if (this.pinned !== null) {
      note(w("help.oldRevision"));
      return;
    }
    if (drafts.isEmpty(this.draft.peek())) this.base = this.detail.revision;
    this.done = [...this.done, this.draft.peek()].slice(-REDO_STEPS);
    this.undone = [];
    this.draft.value = next;
  }

  /** Replace the last change while a hand still moves: one drag is one step. */
  amend(next: Draft): void {
    this.draft.value = next;
  }

  setSamples(track: string, values: Iterable<readonly [number, number]>): void {
    this.attempt(() => drafts.withSamples(this.draft.peek(), track, values));
  }

  setLabels(labels: readonly Span[]): void {
    this.attempt(() => drafts.withLabels(this.draft.peek(), labels, this.labels.peek()));
  }

  setElement(change: drafts.ElementChange): void {
    this.attempt(() => drafts.withElement(this.draft.peek(), change));
  }

  /** Make a change, or say why it would be lost. */
  attempt(make: () => Draft): void {
    const next = drafts.orReplaced(make);
    if (next) this.change(next);
    else note(w("help.replacedByText"), { bad: true });
  }

  /** A change that the repository is asked about first: it says why not, and how it can be. Whether it was made. */
  async tryChange(make: (draft: Draft) => Draft): Promise<boolean> {
    const before = this.draft.peek();
    const next = drafts.orReplaced(() => make(before));
    if (!next) note(w("help.replacedByText"), { bad: true });
    if (!next || this.pinned !== null) return false;
    try {
      const base = drafts.isEmpty(before) ? this.detail.revision : this.base;
      if (!terms.peek().edits) {
        // It can be proposed alone: the repository tries it without the right to edit.
        await ask("post", "/documents/{id}/proposals/preview", {
          path: { id: this.id },
          match: base,
          body: { changes: drafts.asChanges(next) },
        });
        this.change(next);
        return true;
      }
      const answer = await ask("post", "/documents/{id}/changes", {
        path: { id: this.id },
        query: { dry_run: true, merge: true },
        match: base,
        body: drafts.asChanges(next),
      });
      const fault = answer.faults?.[0];
      if (fault) {
        note(fault.what, { detail: fault.remedy ?? undefined, bad: true });
        return false;
      }
    } catch (error) {
      refuse(error);
      return false;
    }
    if (this.draft.peek() !== before) return this.tryChange(make);
    this.change(next);
    return true;
  }

  /** Change a bone's vector at rest (motion/body/shape.ts). before: the draft that a drag began on, whose step this stays. */
  setBone(bone: number, vector: Vector, before?: Draft): void {
    const from = before ?? this.draft.peek();
    const texts = textsOf(this.skeleton.view, bone, vector);
    const made = drafts.orReplaced(() =>
      texts.reduce((draft, { address, text }) => drafts.withElement(draft, { address, attributes: {}, text }), from),
    );
    if (!made) {
      note(w("help.replacedByText"), { bad: true });
      return;
    }
    const next = { ...made, steps: from.steps + 1 };
    if (before && this.draft.peek() !== before) this.amend(next);
    else this.change(next);
  }

  get canUndo(): boolean {
    return this.done.length > 0;
  }

  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  undo(): boolean {
    const before = this.done.pop();
    if (!before) return false;
    this.undone.push(this.draft.peek());
    this.draft.value = before;
    return true;
  }

  redo(): boolean {
    const next = this.undone.pop();
    if (!next) return false;
    this.done.push(this.draft.peek());
    this.draft.value = next;
    return true;
  }

  discard(): void {
    this.change(drafts.EMPTY);
  }

  /** Make one revision of the draft. The caller opens it. */
  async save(message = "", merge = false): Promise<number | null> {
    const answer = await this.send(
      (changes, match) =>
        ask("post", "/documents/{id}/changes", { path: { id: this.id }, query: { merge }, match, body: changes }),
      message,
    );
    return answer?.revision ?? null;
  }

  /** Propose the draft instead of saving it. The number of the proposal. */
  async propose(message: string): Promise<number | null> {
    const answer = await this.send(
      (changes, match) => ask("post", "/documents/{id}/proposals", { path: { id: this.id }, match, body: { changes } }),
      message,
    );
    return answer?.number ?? null;
  }

  private async send<T>(
    post: (changes: Schemas["ChangeSet"], match: number) => Promise<T>,
    message = "",
  ): Promise<T | null> {
    const draft = this.draft.peek();
    if (drafts.isEmpty(draft) || this.saving.peek()) return null;
    this.saving.value = true;
    try {
      const answer = await post(drafts.asChanges(draft, message), this.base);
      batch(() => {
        this.trouble.value = null;
        this.draft.value = drafts.EMPTY;
      });
      return answer;
    } catch (error) {
      this.trouble.value = error;
      return null;
    } finally {
      this.saving.value = false;
    }
  }

  /** Save over what others did to the same places. */
  async insist(): Promise<number | null> {
    const newest = await get("/documents/{id}", { path: { id: this.id } });
    this.base = newest.revision;
    return this.save();
  }

  /** Show another revision of the same document as a ghost; null shows none. against: the revision that it is compared
   * with, instead of the one that is open. */
  async compare(revision: number | null, against: number | null = null): Promise<void> {
    await this.showCompared(revision === null ? null : (signal) => compareRevisions(this, revision, against, signal));
  }

  /** Show the motion that a proposal would make as a ghost. */
  async compareProposal(number: number): Promise<void> {
    await this.showCompared((signal) => compareProposal(this, number, signal));
  }

  private async showCompared(find: ((signal: AbortSignal) => Promise<Compared | null>) | null): Promise<void> {
    this.forgetCompared();
    if (!find) return;
    const stop = (this.comparing = new AbortController());
    try {
      const found = await find(stop.signal);
      if (found && !stop.signal.aborted) this.compared.value = found;
    } catch (error) {
      refuse(error);
    }
  }

  private forgetCompared(): void {
    this.comparing?.abort();
    this.compared.peek()?.blocks.close();
    this.compared.peek()?.against?.blocks.close();
    this.compared.value = null;
    this.flipped.value = false;
  }

  // Drafts survive a reload.

  private get key(): string {
    return `mcml.draft.${this.id}`;
  }

  private keep(draft: Draft): void {
    if (this.pinned !== null) return;
    try {
      if (drafts.isEmpty(draft)) localStorage.removeItem(this.key);
      else localStorage.setItem(this.key, drafts.frozen(draft, this.base));
    } catch {
      /* A full or forbidden storage keeps nothing. */
    }
  }

  private revive(): void {
    try {
      const text = localStorage.getItem(this.key);
      if (!text) return;
      const found = drafts.revived(text);
      this.base = found.base;
      this.draft.value = found.draft;
    } catch {
      /* What cannot be read is no draft. */
    }
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.player.pause();
    this.blocks.close();
    this.channels.close();
    this.rotations.close();
    this.forgetCompared();
  }
}

/** Open a document at a revision, or as it is. */
export async function openClip(id: string, revision: number | null, signal: AbortSignal): Promise<Clip> {
  const query = revision === null ? {} : { revision };
  const detail = await get("/documents/{id}", { path: { id }, query, signal });
  const view = await get("/documents/{id}/skeleton", { path: { id }, query: { revision: detail.revision }, signal });
  return new Clip(detail, view, revision);
}
