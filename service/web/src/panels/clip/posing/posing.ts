/** The pose that is being made of a clip: which parts are moved and how far, and a preview of the motion by the server. */
import { batch, computed, effect, signal } from "@preact/signals";
import { numberAt } from "../../../lists";
import type { Vector } from "../../../motion/body/quaternions";
import { previewOf, stepFor, type Preview } from "../../../motion/loading/preview";
import type { Clip } from "../../../state/clip/clip";
import { previewEdits } from "../timeline/editFrames";
import type { Edits } from "../timeline/edits";
import { fadedRange, handleOf, handlesOf, JOINTS, poseEdit, STILL, type HandleName, type Moved } from "./handles";

const USUAL_FADE = 0.3; // s

interface Seen {
  /** Positions from 0. */
  first: number;
  last: number;
  motion: Preview;
  /** From the origin of the preview to that of the clip. */
  offset: Vector;
  notes: string[];
}

export class Posing {
  readonly moves = signal<ReadonlyMap<HandleName, Moved>>(new Map());
  readonly range = signal<readonly [number, number]>([1, 1]);
  readonly fade = signal(0);
  readonly keepFeet = signal(true);
  readonly seen = signal<Seen | null>(null);
  readonly trouble = signal<unknown>(null);
  readonly busy = signal(false);
  readonly handles: readonly HandleName[];
  /** The handle of the selected joint. */
  readonly chosen = computed(() => handleOf(this.clip.selection.value.bones[0]));
  readonly edits = computed(() =>
    poseEdit(
      { moves: this.moves.value, range: this.range.value, fade: this.fade.value, keepFeet: this.keepFeet.value },
      this.clip.frames,
    ),
  );
  private readonly closing = new AbortController();
  private wanted = 0;
  private running: Promise<void> | null = null;
  private readonly stop: () => void;

  constructor(readonly clip: Clip) {
    const { player } = clip;
    player.pause();
    const here = player.frame.peek();
    const loop = player.loop.peek();
    this.range.value = loop && loop[0] <= here && here <= loop[1] ? [loop[0] + 1, loop[1] + 1] : [here + 1, here + 1];
    this.fade.value = Math.round(USUAL_FADE * player.perSecond);
    this.handles = handlesOf(clip.skeleton);
    if (!this.chosen.peek()) this.choose(this.handles.find((name) => name === "right_hand") ?? this.handles[0]);
    this.stop = effect(() => {
      void this.edits.value;
      this.refresh();
    });
  }

  choose(handle: HandleName | undefined): void {
    if (handle) this.clip.select([JOINTS[handle]]);
  }

  moved(handle: HandleName): Moved {
    return this.moves.value.get(handle) ?? STILL;
  }

  set(handle: HandleName, moved: Moved): void {
    this.moves.value = new Map([...this.moves.peek(), [handle, moved]]);
  }

  /** Joints and tips at a frame, posed; null: as they are. */
  positions(frame: number): Float32Array | null {
    const seen = this.seen.value;
    if (!seen || frame < seen.first || frame > seen.last) return null;
    return seen.motion.frame(frame - seen.first).map((one, at) => one + numberAt(seen.offset, at % 3));
  }

  /** Whether the whole pose is in a frame. */
  isWhole(frame: number): boolean {
    const [first, last] = this.range.value;
    return frame + 1 >= first && frame + 1 <= last;
  }

  /** Ask the server for the newest pose, one request at a time. */
  private refresh(): void {
    this.wanted++;
    this.running ??= this.ask().finally(() => {
      this.running = null;
      this.busy.value = false;
    });
  }

  private async ask(): Promise<void> {
    this.busy.value = true;
    for (let asked = 0; asked < this.wanted && !this.isClosed();) {
      asked = this.wanted;
      try {
        const seen = await this.preview();
        batch(() => {
          this.seen.value = seen;
          this.trouble.value = null;
        });
      } catch (error) {
        if (!this.isClosed()) this.trouble.value = error;
      }
    }
  }

  /** The edits, once all previews have arrived: those on their way would ask for a revision that is no longer the newest. */
  async settled(): Promise<Edits | null> {
    await this.running;
    return this.edits.peek();
  }

  private async preview(): Promise<Seen | null> {
    const { clip } = this;
    const edits = this.edits.peek();
    if (!edits) return null;
    const [first, last] = fadedRange(this.range.peek(), this.fade.peek(), clip.frames);
    const frames = last - first + 1;
    const step = stepFor(frames, clip.skeleton.points);
    const made = await previewEdits(clip, edits, { curve: null, seen: { first, last, step } }, this.closing.signal);
    if (!made.motion) return null;
    const { origin } = clip.skeleton.view;
    return {
      first: first - 1,
      last: last - 1,
      motion: previewOf(made.motion, clip.skeleton, frames, clip.player.perSecond, step),
      offset: made.motion.origin.map((one, axis) => one - numberAt(origin, axis)) as Vector,
      notes: made.notes,
    };
  }

  private isClosed(): boolean {
    return this.closing.signal.aborted;
  }

  close(): void {
    this.closing.abort();
    this.stop();
  }
}

/** The pose in the making; null: none. */
export const posing = signal<Posing | null>(null);

export function startPosing(clip: Clip): void {
  stopPosing();
  posing.value = new Posing(clip);
}

export function stopPosing(): void {
  posing.peek()?.close();
  posing.value = null;
}
