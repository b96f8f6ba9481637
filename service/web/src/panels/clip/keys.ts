/** The keys of the clip page. */
import { useEffect } from "preact/hooks";
import { ask } from "../../api/client";
import type { Clip } from "../../state/clip/clip";
import { besideIds, putBeside } from "../../state/clip/comparison";
import { message, mustPropose } from "../../state/clip/review";
import { offer, type Command } from "../../state/session/keys";
import { note, refuse } from "../../state/session/notes";
import { param, setParams } from "../../state/session/route";
import { w } from "../../words";
import { clipActions } from "./actions";
import { r } from "./words";

/** Tell of a new proposal, and lead to it. */
export function noteProposal(n: number): void {
  note(r("label.proposed", { n }), { action: { text: w("button.open"), run: () => setParams({ tab: "proposals" }) } });
}

/** Propose the draft, which others review. */
export async function proposeClip(clip: Clip): Promise<void> {
  const number = await clip.propose(message.peek().trim());
  if (number === null) return;
  message.value = "";
  noteProposal(number);
}

export async function saveClip(clip: Clip, reload: () => void, merge = false): Promise<void> {
  if (mustPropose()) return proposeClip(clip);
  const revision = await clip.save(message.peek().trim(), merge);
  if (revision === null) return;
  message.value = "";
  note(w("label.saved", { n: revision }), {
    action: { text: w("button.undo"), run: () => void undoSaved(clip, revision, reload) },
  });
  reload();
}

/** Take a stored revision back. */
export async function undoSaved(clip: Clip, revision: number, reload: () => void): Promise<void> {
  try {
    await ask("post", "/documents/{id}/undo", { path: { id: clip.id }, query: { revision }, match: revision });
    reload();
  } catch (error) {
    refuse(error);
  }
}

/** The old pose instead of the new one, until the key is let go. */
function flipWhileHeld(clip: Clip): void {
  if (clip.flipped.peek()) return;
  clip.flipped.value = true;
  const back = (event: Event) => {
    if (event instanceof KeyboardEvent && event.code !== "KeyC") return;
    clip.flipped.value = false;
    removeEventListener("keyup", back);
    removeEventListener("blur", back);
  };
  addEventListener("keyup", back);
  addEventListener("blur", back);
}

export function useClipKeys(clip: Clip, reload: () => void): void {
  useEffect(() => {
    const { player } = clip;
    const edges = () =>
      [...new Set(clip.labels.peek().flatMap((span) => [span.first - 1, span.last]))].sort((a, b) => a - b);
    const speeds = [0.25, 0.5, 1, 2, 4];
    const list: Command[] = [
      { id: "play", word: "button.play", keys: ["Space"], run: () => player.toggle() },
      { id: "back", word: "label.backFrame", keys: ["Left", ","], run: () => player.step(-1) },
      { id: "next", word: "label.nextFrame", keys: ["Right", "."], run: () => player.step(1) },
      { id: "tenBack", word: "label.tenBack", keys: ["Shift+Left", "Shift+,"], run: () => player.step(-10) },
      { id: "tenOn", word: "label.tenOn", keys: ["Shift+Right", "Shift+."], run: () => player.step(10) },
      { id: "first", word: "label.firstFrame", keys: ["Home"], run: () => player.seek(player.range[0]) },
      { id: "last", word: "label.lastFrame", keys: ["End"], run: () => player.seek(player.range[1]) },
      {
        id: "edgeBack",
        word: "label.previousEdge",
        keys: ["PgUp"],
        run: () => player.seek(edges().findLast((edge) => edge < player.frame.peek()) ?? 0),
      },
      {
        id: "edgeNext",
        word: "label.nextEdge",
        keys: ["PgDn"],
        run: () => player.seek(edges().find((edge) => edge > player.frame.peek()) ?? clip.frames - 1),
      },
      { id: "j", word: "label.slower", keys: ["J"], run: () => player.shuttle(-1) },
      { id: "k", word: "button.stop", keys: ["K"], run: () => player.pause() },
      { id: "l", word: "label.faster", keys: ["L"], run: () => player.shuttle(1) },
      { id: "in", word: "button.setIn", keys: ["I"], run: () => clipActions.setLoop(clip, "in") },
      { id: "out", word: "button.setOut", keys: ["O"], run: () => clipActions.setLoop(clip, "out") },
      { id: "noLoop", word: "button.clearLoop", keys: ["\\"], run: () => (player.loop.value = null) },
      ...speeds.map((speed, index): Command => ({
        id: `speed${speed}`,
        word: "label.speed",
        keys: [String(index + 1)],
        run: () => (player.speed.value = speed),
      })),
      {
        id: "undo",
        word: "button.undo",
        keys: ["Ctrl+Z"],
        run: () => {
          if (!clip.undo()) clipActions.undoStored(clip, reload);
        },
      },
      { id: "redo", word: "button.redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], run: () => clip.redo() },
      { id: "save", word: "button.save", keys: ["Ctrl+S"], run: () => void saveClip(clip, reload) },
      {
        id: "dock",
        word: "label.dock",
        keys: ["D"],
        run: () => setParams({ dock: param("dock") === "below" ? null : "below" }),
      },
      { id: "frame", word: "label.frameSelection", keys: ["F"], run: () => clipActions.frame() },
      { id: "follow", word: "label.follow", keys: ["Shift+F"], run: () => clipActions.toggle("follow") },
      { id: "trails", word: "label.trails", keys: ["T"], run: () => clipActions.toggle("trails") },
      { id: "body", word: "label.bodyShown", keys: ["B"], run: () => clipActions.toggle("body") },
      { id: "view", word: "label.view", keys: ["V"], run: () => clipActions.nextView() },
      { id: "split", word: "button.spanSplit", keys: ["S"], run: () => clipActions.splitSpan(clip) },
      { id: "name", word: "label.spanAdd", keys: ["N"], run: () => clipActions.nameLoop(clip) },
      {
        id: "flip",
        word: "label.flipRevisions",
        keys: ["C"],
        run: () => flipWhileHeld(clip),
        when: () => clip.compared.value !== null,
      },
      {
        id: "leaveCompared",
        word: "label.leaveCompared",
        keys: ["Esc"],
        run: () => putBeside([]),
        when: () => besideIds().length > 0 && !clip.selection.value.bones.length,
      },
      {
        id: "esc",
        word: "label.none",
        keys: ["Esc"],
        run: () => clip.select([]),
        when: () => clip.selection.value.bones.length > 0,
      },
    ];
    return offer("clip", list);
  }, [clip]);
}
