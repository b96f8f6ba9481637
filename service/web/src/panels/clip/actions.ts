/** What keys and buttons of the clip page do alike. */
import { itemAt } from "../../lists";
import { signal } from "@preact/signals";
import { ask } from "../../api/client";
import type { Clip } from "../../state/clip/clip";
import type { Span } from "../../state/editing/draft";
import { setParams } from "../../state/session/route";
import { note, refuse } from "../../state/session/notes";
import { kept } from "../../state/session/settings";
import type { CameraView, Shown } from "../../scene/stage";
import { w } from "../../words";
import { writeExample, type Example } from "./similar/asked";

const SHOWN: Shown = {
  follow: true,
  ghosts: false,
  trails: false,
  names: false,
  axes: true,
  body: false,
  forces: true,
};
/** What is drawn, and how; stays from clip to clip. */
export const shown = kept<Shown>("shown", SHOWN);
// What an earlier version kept lacks later switches.
shown.value = { ...SHOWN, ...shown.peek() };
export const cameraView = signal<CameraView>("persp");
/** Moves when the camera shall look at the selection, or at the body. */
export const frameAsked = signal(0);
/** The span that is being named, at its place; null: none. */
export const naming = signal<{ span: Span; fresh: boolean } | null>(null);
const VIEWS: CameraView[] = ["persp", "front", "side", "top"];
let lastNew = 0;
/** Whether a button has just asked for similar motion: the answer gets the focus. */
export const similarAsked = { now: false };

export const newSpan = (name: string, first: number, last: number): Span => ({ id: --lastNew, name, first, last });

export const clipActions = {
  toggle(name: keyof Shown): void {
    shown.value = { ...shown.peek(), [name]: !shown.peek()[name] };
  },
  nextView(): void {
    cameraView.value = itemAt(VIEWS, (VIEWS.indexOf(cameraView.peek()) + 1) % VIEWS.length);
  },
  frame(): void {
    frameAsked.value++;
  },
  setLoop(clip: Clip, edge: "in" | "out"): void {
    const { player } = clip;
    const [first, last] = player.range;
    const here = player.frame.peek();
    player.loop.value = edge === "in" ? [here, Math.max(here, last)] : [Math.min(first, here), here];
  },
  /** Begin to name the loop, or a second around the playhead. */
  nameLoop(clip: Clip): void {
    const { player } = clip;
    const half = Math.round(player.perSecond / 2);
    const here = player.frame.peek();
    const [first, last] = player.loop.peek() ?? [Math.max(0, here - half), Math.min(clip.frames - 1, here + half)];
    naming.value = { span: newSpan("", first + 1, last + 1), fresh: true };
  },
  /** Split the spans under the playhead; only: the one that is meant. */
  splitSpan(clip: Clip, only?: number): void {
    const here = clip.player.frame.peek() + 1;
    const inside = clip.labels
      .peek()
      .filter((span) => span.first < here && span.last >= here && (only === undefined || span.id === only));
    if (!inside.length) {
      note(w("error.nothingToSplit"));
      return;
    }
    clip.setLabels(
      clip.labels
        .peek()
        .flatMap((span) =>
          inside.includes(span) ? [{ ...span, last: here - 1 }, newSpan(span.name, here, span.last)] : [span],
        ),
    );
  },
  /** Search for motions like the loop, or for poses like the one at the playhead; a range that is being labelled is let go. */
  findSimilar(clip: Clip, example?: Example): void {
    const { player } = clip;
    const loop = player.loop.peek();
    const asked = example ?? (loop ? { first: loop[0] + 1, last: loop[1] + 1 } : { first: player.frame.peek() + 1 });
    setParams({ like: writeExample(asked), likeof: null, likemax: null }, true);
    naming.value = null;
    similarAsked.now = true;
  },
  async undoStored(clip: Clip, reload: () => void): Promise<void> {
    if (clip.detail.revision <= 1 || clip.pinned !== null) return;
    try {
      await ask("post", "/documents/{id}/undo", { path: { id: clip.id }, match: clip.detail.revision });
      note(w("button.undo"));
      reload();
    } catch (error) {
      refuse(error);
    }
  },
};
