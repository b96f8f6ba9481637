/** Edits of frames, made at once as a revision of their own, which the toast takes back. */
import { itemAt } from "../../../lists";
import { ask, type Schemas } from "../../../api/client";
import type { CurveName } from "../../../motion/timeline/comparing";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { w } from "../../../words";
import { go } from "../../../state/session/route";
import { message, mustPropose } from "../../../state/clip/review";
import { markReplaced } from "./replacedMarks";
import { noteProposal, saveClip, undoSaved } from "../keys";
import type { Edits, Seen } from "./edits";

/** Whether a draft has to be saved first, which is told: its frames are positions, which would mean others afterwards. */
function hasDraft(clip: Clip, reload: () => void): boolean {
  if (!clip.changed.peek()) return false;
  note(w("help.saveFirst"), { action: { text: w("button.save"), run: () => void saveClip(clip, reload) } });
  return true;
}

export async function editFrames(clip: Clip, reload: () => void, edits: Edits): Promise<void> {
  if (mustPropose()) return proposeFrames(clip, reload, edits);
  if (hasDraft(clip, reload)) return;
  try {
    const made = await ask("post", "/documents/{id}/frames", {
      path: { id: clip.id },
      match: clip.detail.revision,
      body: { edits, renumber: true, message: message.peek().trim() },
    });
    message.value = "";
    markReplaced(clip.id, made);
    const { player } = clip;
    player.pause();
    player.loop.value = null;
    player.seek(Math.min(player.frame.peek(), made.frames - 1));
    note([w("label.framesNow", { n: made.frames }), ...made.notes].join("; "), {
      action: { text: w("button.undo"), run: () => void undoSaved(clip, made.revision, reload) },
    });
    reload();
  } catch (error) {
    refuse(error);
  }
}

/** Propose edits, which others review. */
export async function proposeFrames(clip: Clip, reload: () => void, edits: Edits): Promise<void> {
  if (hasDraft(clip, reload)) return;
  try {
    const made = await ask("post", "/documents/{id}/proposals", {
      path: { id: clip.id },
      match: clip.detail.revision,
      body: { edits: { edits, renumber: true, message: message.peek().trim() } },
    });
    message.value = "";
    noteProposal(made.number);
  } catch (error) {
    refuse(error);
  }
}

export type Made = Schemas["FramesEdited"];

/** Frames first to last as a clip of their own, edited; the toast opens it. edits: of positions in the new clip. */
export async function extractFrames(
  clip: Clip,
  reload: () => void,
  [first, last]: [number, number],
  name: string,
  edits: Edits = [],
): Promise<void> {
  if (hasDraft(clip, reload)) return;
  const { items } = await ask("post", "/documents/{id}/split", {
    path: { id: clip.id },
    body: { first, last, name, at: [] },
  });
  const id = itemAt(items, 0).document;
  let told: string[] = [];
  if (edits.length) {
    try {
      const body = { edits, renumber: true, message: "" };
      told = (await ask("post", "/documents/{id}/frames", { path: { id }, match: 1, body })).notes;
    } catch (error) {
      // Without its edit the clip is not what was asked for.
      await ask("delete", "/documents/{id}", { path: { id }, match: 1 });
      throw error;
    }
  }
  note([w("label.extracted", { name }), ...told].join("; "), {
    action: { text: w("button.open"), run: () => go(`/clips/${id}`) },
  });
}

/** What edits would do, without making them: notes, a curve before and after, and the frames of the motion that are to be seen. */
export async function previewEdits(
  clip: Clip,
  edits: Edits,
  { curve, seen }: { curve: CurveName | null; seen: Seen | null },
  signal: AbortSignal,
): Promise<Made> {
  return ask("post", "/documents/{id}/proposals/preview", {
    path: { id: clip.id },
    match: clip.detail.revision,
    body: { edits: { edits, renumber: true, message: "" } },
    query: {
      ...(curve ? { [curve.kind]: [curve.name] } : {}),
      ...(seen ? { positions: "f4" as const, ...seen } : {}),
    },
    signal,
  });
}
