/** Frames taken out, kept alone, copied, held: at once, as a revision of its own, which the toast takes back. */
import { useState } from "preact/hooks";
import { holding } from "../../../motion/timeline/holding";
import type { Clip } from "../../../state/clip/clip";
import { terms } from "../../../state/clip/review";
import { Dialog } from "../../../ui/Dialog";
import { AskName } from "../../../ui/forms/AskName";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { number, w } from "../../../words";
import { clipActions } from "../actions";
import { handlesOf } from "../posing/handles";
import { startPosing } from "../posing/posing";
import { p } from "../posing/words";
import { chooseMotion } from "../replacing/asked";
import { r } from "../words";
import { CleanUp } from "./CleanUp";
import { editFrames, extractFrames } from "./editFrames";
import { CHANGES, REPAIRS } from "./edits";

const CHANGE_WORDS = {
  loop: "button.makeLoop",
  "in-place": "button.keepInPlace",
  speed: "button.changeSpeed",
  mirror: "button.mirrorSides",
} as const;
const MOST_HELD = 100_000;

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
  const [edit, setEdit] = useState<"repair" | (typeof CHANGES)[number] | null>(null);
  const [extracts, setExtracts] = useState(false);
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
              run: () => void editFrames(clip, reload, [{ do: "delete", ...of }]),
            },
            {
              text: w("button.extractFrames", of),
              disabled: !terms.value.edits,
              run: () => setExtracts(true),
            },
            {
              text: w("button.cropTo", of),
              disabled: all,
              run: () => void editFrames(clip, reload, [{ do: "keep", ...of }]),
            },
            {
              text: w("button.duplicateFrames", of),
              run: () => void editFrames(clip, reload, [{ do: "insert", ...of, at: of.last + 1 }]),
            },
            {
              text: w("button.copyFramesTo", { ...of, n: here }),
              run: () => void editFrames(clip, reload, [{ do: "insert", ...of, at: here }]),
            },
          ]
        : [{ text: w("button.chooseRange"), disabled: true }]),
      { text: w("button.holdFrame", { n: here }), run: () => setHolds(here) },
      ...(handlesOf(clip.skeleton).length
        ? [{ text: p("button.poseBody"), disabled: clip.changed.value, run: () => startPosing(clip) }]
        : []),
      ...CHANGES.map((kind) => ({ text: w(CHANGE_WORDS[kind]), run: () => setEdit(kind) })),
      { text: w("button.repairFrames"), run: () => setEdit("repair") },
      ...(terms.value.edits && !terms.value.review
        ? [{ text: r("button.replaceMotion"), disabled: clip.changed.value, run: () => chooseMotion(clip.id) }]
        : []),
      { text: w("button.spanSplit"), detail: "S", run: () => clipActions.splitSpan(clip) },
    ];
  };
  return (
    <>
      <Menu label={w("button.editFrames")} className="button quiet dense" side="right" items={items}>
        {w("label.framesWord")}
        <Icon name="down" />
      </Menu>
      {edit && (
        <CleanUp
          clip={clip}
          range={range}
          kinds={edit === "repair" ? REPAIRS : [edit]}
          title={w(edit === "repair" ? "button.repairFrames" : CHANGE_WORDS[edit])}
          reload={reload}
          onClose={() => setEdit(null)}
        />
      )}
      {extracts && range && (
        <AskName
          title={w("button.extractFrames", { first: range[0], last: range[1] })}
          initial={`${clip.detail.name} ${range[0]}–${range[1]}`}
          onName={(name) => extractFrames(clip, reload, range, name)}
          onClose={() => setExtracts(false)}
        >
          <p class="dim">{w("help.extractFrames")}</p>
        </AskName>
      )}
      {holds !== null && (
        <Hold
          frame={holds}
          rate={clip.player.perSecond}
          onClose={() => setHolds(null)}
          onHold={(more) => {
            setHolds(null);
            void editFrames(clip, reload, holding(holds, more));
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
