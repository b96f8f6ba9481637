/** Edits of frames, made at once as a revision of their own, which the toast takes back. */
import { ask, type Schemas } from "../../../api/client";
import type { CurveName } from "../../../motion/timeline/comparing";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { w } from "../../../words";
import { saveClip, undoSaved } from "../keys";

export type Edits = Schemas["FrameEdits"]["edits"];

export async function editFrames(clip: Clip, reload: () => void, edits: Edits): Promise<void> {
  // Frames of a draft are positions, which would mean others afterwards.
  if (clip.changed.peek()) {
    note(w("help.saveFirst"), { action: { text: w("button.save"), run: () => void saveClip(clip, reload) } });
    return;
  }
  try {
    const made = await ask("post", "/documents/{id}/frames", {
      path: { id: clip.id },
      match: clip.detail.revision,
      body: { edits, renumber: true, message: "" },
    });
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

export type Made = Schemas["FramesEdited"];

/** What edits would do, without making them: notes, and a curve before and after. */
export async function previewEdits(
  clip: Clip,
  edits: Edits,
  curve: CurveName | null,
  signal: AbortSignal,
): Promise<Made> {
  return ask("post", "/documents/{id}/frames", {
    path: { id: clip.id },
    match: clip.detail.revision,
    body: { edits, renumber: true, message: "" },
    query: { dry_run: true, ...(curve ? { [curve.kind]: [curve.name] } : {}) },
    signal,
  });
}
