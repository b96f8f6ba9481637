/** Frames taken out, kept alone, copied, held: at once, as a revision of its own, which the toast takes back. */
import { useState } from "preact/hooks";
import { ask, type Schemas } from "../../../api/client";
import { holding } from "../../../motion/timeline/holding";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { Dialog } from "../../../ui/Dialog";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { number, w } from "../../../words";
import { clipActions } from "../actions";
import { saveClip, undoSaved } from "../keys";

type Edits = Schemas["FrameEdits"]["edits"];
const MOST_HELD = 100_000;

async function edit(clip: Clip, reload: () => void, edits: Edits): Promise<void> {
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
    note(w("label.framesNow", { n: made.frames }), {
      action: { text: w("button.undo"), run: () => void undoSaved(clip, made.revision, reload) },
    });
    reload();
  } catch (error) {
    refuse(error);
  }
}

/** range: the frames that are meant, from 1; null: none are chosen, and the menu says how. */
export function FramesMenu({
  clip,
  range,
  reload,
}: {
  clip: Clip;
  range: [number, number] | null;
  reload: () => void;
}) {
  const [holds, setHolds] = useState<number | null>(null);
  if (clip.pinned !== null || !clip.frames) return null;
  const of = range && { first: range[0], last: range[1] };
  const items = () => {
    const here = clip.player.frame.peek() + 1;
    const all = of?.first === 1 && of.last === clip.frames;
    return [
      ...(of
        ? [
            {
              text: w("button.deleteFrames", of),
              icon: "trash" as const,
              disabled: all,
              run: () => void edit(clip, reload, [{ do: "delete", ...of }]),
            },
            {
              text: w("button.cropTo", of),
              disabled: all,
              run: () => void edit(clip, reload, [{ do: "keep", ...of }]),
            },
            {
              text: w("button.duplicateFrames", of),
              run: () => void edit(clip, reload, [{ do: "insert", ...of, at: of.last + 1 }]),
            },
            {
              text: w("button.copyFramesTo", { ...of, n: here }),
              run: () => void edit(clip, reload, [{ do: "insert", ...of, at: here }]),
            },
          ]
        : [{ text: w("button.chooseRange"), disabled: true }]),
      { text: w("button.holdFrame", { n: here }), run: () => setHolds(here) },
      { text: w("button.spanSplit"), detail: "S", run: () => clipActions.splitSpan(clip) },
    ];
  };
  return (
    <>
      <Menu label={w("button.editFrames")} className="button quiet dense" side="right" items={items}>
        {w("label.framesWord")}
        <Icon name="down" />
      </Menu>
      {holds !== null && (
        <Hold
          frame={holds}
          rate={clip.player.perSecond}
          onClose={() => setHolds(null)}
          onHold={(more) => {
            setHolds(null);
            void edit(clip, reload, holding(holds, more));
          }}
        />
      )}
    </>
  );
}

function Hold({
  frame,
  rate,
  onClose,
  onHold,
}: {
  frame: number;
  rate: number;
  onClose: () => void;
  onHold: (more: number) => void;
}) {
  const [more, setMore] = useState(Math.max(1, Math.round(rate / 2)));
  const sound = Number.isInteger(more) && more >= 1 && more <= MOST_HELD;
  return (
    <Dialog title={w("button.holdFrame", { n: frame })} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (sound) onHold(more);
        }}
      >
        <p class="row">
          <label class="row">
            {w("label.forFrames")}{" "}
            <input
              class="field number"
              type="number"
              autoFocus
              min={1}
              max={MOST_HELD}
              value={more}
              onInput={(event) => setMore(Number(event.currentTarget.value))}
            />
          </label>
          <span class="dim grow">{number(more / rate, 2)} s</span>
          <button type="submit" class="button primary" disabled={!sound}>
            {w("button.apply")}
          </button>
        </p>
      </form>
    </Dialog>
  );
}
