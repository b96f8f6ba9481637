/** An edit of frames: chosen, previewed by what would change, then made, here or as a clip of its own. */
import { useEffect, useState } from "preact/hooks";
import { startCurve, type CurveName } from "../../../motion/timeline/comparing";
import { numbersOf, stepFor, wholeOf } from "../../../motion/loading/preview";
import type { Clip } from "../../../state/clip/clip";
import { refuse } from "../../../state/session/notes";
import { Dialog } from "../../../ui/Dialog";
import { WholeMotion } from "../../../ui/playing/WholeMotion";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w } from "../../../words";
import { CurvePreview } from "./CurvePreview";
import { mustPropose, terms } from "../../../state/clip/review";
import { r } from "../words";
import { MessageField } from "../review/MessageField";
import { editFrames, extractFrames, previewEdits, proposeFrames, type Made } from "./editFrames";
import { EditFields } from "./EditFields";
import { editOf, isSeen, seenFrames, START, type Choices, type Edits, type Kind, type Seen } from "./edits";

const TITLES = {
  fill: "label.cleanFill",
  despike: "label.cleanDespike",
  "low-pass": "label.cleanLowPass",
  unroll: "label.cleanUnroll",
  "lock-feet": "label.cleanLockFeet",
  loop: "label.cleanLoop",
  "in-place": "label.stayInPlace",
  speed: "label.changeSpeed",
  mirror: "label.mirrorSides",
} as const;
const HELP = {
  fill: "help.cleanFill",
  despike: "help.cleanDespike",
  "low-pass": "help.cleanLowPass",
  unroll: "help.cleanUnroll",
  "lock-feet": "help.cleanLockFeet",
  loop: "help.cleanLoop",
  "in-place": "help.stayInPlace",
  speed: "help.changeSpeed",
  mirror: "help.mirrorSides",
} as const;
const WAIT = 300; // ms after the last change

/** The dry run of edits: the motion, or a curve: the chosen one, else of the selected joint, else of the one with the most
 * new samples. */
function usePreview(clip: Clip, edits: Edits, seen: Seen | null) {
  const [chosen, setChosen] = useState<CurveName | null>(null);
  const [most, setMost] = useState<string | null>(null);
  const { bones } = clip.selection.value;
  const curve =
    chosen ??
    (most !== null && !bones.length
      ? { kind: "column" as const, name: most }
      : startCurve(clip.skeleton.view.bones, bones));
  const preview = useAsync(
    async (signal) => {
      await new Promise((resolve) => setTimeout(resolve, WAIT));
      signal.throwIfAborted();
      return previewEdits(clip, edits, { curve: seen ? null : curve, seen }, signal);
    },
    [JSON.stringify([edits, seen ? null : curve])],
  );
  const made = preview.value ?? preview.before;
  const found = preview.value?.replaced[0];
  const changed = found && `${found.bone}.${found.channels[0]}`;
  useEffect(() => {
    if (changed !== undefined) setMost(changed);
  }, [changed]);
  return { preview, made, curve, choose: setChosen };
}

export function CleanUp({
  clip,
  range,
  kinds,
  title,
  reload,
  onClose,
}: {
  clip: Clip;
  range: [number, number] | null;
  /** Edits to choose from. */
  kinds: readonly [Kind, ...Kind[]];
  title: string;
  reload: () => void;
  onClose: () => void;
}) {
  const [kind, setKind] = useState<Kind>(kinds[0]);
  const { bones } = clip.selection.value;
  const [choices, setChoices] = useState<Choices>({ ...START, selected: bones.length > 0 });
  // A loop leaves out all other frames: the clip stays unless that is wanted.
  const [name, setName] = useState<string | null>(
    kind === "loop" && !mustPropose() ? w("label.loopOf", { name: clip.detail.name }) : null,
  );
  const span = range ?? ([1, clip.frames] as [number, number]);
  const count = span[1] - span[0] + 1;
  const edits = editOf(kind, choices, bones, span);
  const step = stepFor(count, clip.skeleton.points);
  const seen = isSeen(kind) ? { ...seenFrames(kind, choices, span), step } : null;
  const [ready, setReady] = useState(false);
  const apply = () => {
    onClose();
    if (name === null) void editFrames(clip, reload, edits);
    else extractFrames(clip, reload, span, name.trim(), editOf(kind, choices, bones, [1, count])).catch(refuse);
  };
  const propose = () => {
    onClose();
    void proposeFrames(clip, reload, edits);
  };
  return (
    <Dialog title={title} onClose={onClose}>
      <form
        class="clean-up"
        onSubmit={(event) => {
          event.preventDefault();
          apply();
        }}
      >
        {kinds.length > 1 && <KindChoice kinds={kinds} kind={kind} onChoose={setKind} />}
        <p class="dim">{w(HELP[kind])}</p>
        <EditFields
          kind={kind}
          choices={choices}
          selected={bones.length}
          onChange={(more) => setChoices({ ...choices, ...more })}
        />
        <p>{kind === "unroll" ? w("label.cleanAll") : w("label.cleanRange", { first: span[0], last: span[1] })}</p>
        <Result clip={clip} edits={edits} seen={seen} onState={setReady} />
        {seen && !mustPropose() && <Target clip={clip} title={w(TITLES[kind])} name={name} onName={setName} />}
        <Acts ready={ready} name={name} onPropose={propose} />
      </form>
    </Dialog>
  );
}

/** The buttons of the dialog. name: of a new clip; null: this clip. */
function Acts({ ready, name, onPropose }: { ready: boolean; name: string | null; onPropose: () => void }) {
  if (mustPropose())
    return (
      <div class="row wrap">
        <span class="dim grow">{r(terms.value.edits ? "help.reviewRequired" : "help.viewersPropose")}</span>
        <MessageField />
        <button type="submit" class="button primary" title={r("help.propose")} disabled={!ready}>
          {r("button.propose")}
        </button>
      </div>
    );
  return (
    <div class="row">
      <span class="grow" />
      {name === null && <MessageField />}
      {name === null && (
        <button type="button" class="button" title={r("help.propose")} disabled={!ready} onClick={onPropose}>
          {r("button.propose")}
        </button>
      )}
      <button type="submit" class="button primary" disabled={!ready || name?.trim() === ""}>
        {w(name === null ? "button.apply" : "button.saveAsClip")}
      </button>
    </div>
  );
}

function KindChoice({ kinds, kind, onChoose }: { kinds: readonly Kind[]; kind: Kind; onChoose: (kind: Kind) => void }) {
  return (
    <label class="row">
      {w("label.cleanKind")}
      <select class="field" value={kind} onChange={(event) => onChoose(event.currentTarget.value as Kind)}>
        {kinds.map((one) => (
          <option key={one} value={one}>
            {w(TITLES[one])}
          </option>
        ))}
      </select>
    </label>
  );
}

/** What the edits would change: in words, and as the motion or a curve. onState: told whether they can be made. */
function Result({
  clip,
  edits,
  seen,
  onState,
}: {
  clip: Clip;
  edits: Edits;
  seen: Seen | null;
  onState: (ready: boolean) => void;
}) {
  const { preview, made, curve, choose } = usePreview(clip, edits, seen);
  const ready = !preview.busy && !preview.error;
  useEffect(() => onState(ready), [ready, onState]);
  return (
    <>
      <Trouble error={preview.error} />
      <div role="status" aria-busy={preview.busy} aria-label={w("label.preview")}>
        <ul class="clean-notes">
          {made?.notes.map((one) => (
            <li key={one}>{one}</li>
          ))}
          {preview.busy && <li class="busy" />}
        </ul>
      </div>
      {seen && <EditedMotion motion={made?.motion} step={seen.step} />}
      {!seen && curve && !preview.error && (
        <CurvePreview clip={clip} made={made} busy={preview.busy} chosen={curve} choose={choose} />
      )}
    </>
  );
}

/** The edited motion, playing. */
function EditedMotion({ motion, step }: { motion: Made["motion"]; step: number }) {
  if (!motion) return <div class="edited-motion" />;
  const seconds = (motion.seconds_per_frame ?? 1 / 30) * step;
  return (
    <WholeMotion
      key={motion.data}
      motion={wholeOf({ ...motion, seconds_per_frame: seconds }, numbersOf(motion))}
      label={w("label.previewWord")}
      className="edited-motion"
    />
  );
}

/** Where the result goes. name: of a new clip; null: this clip. */
function Target({
  clip,
  title,
  name,
  onName,
}: {
  clip: Clip;
  title: string;
  name: string | null;
  onName: (name: string | null) => void;
}) {
  return (
    <fieldset class="edit-target">
      <legend>{w("label.saveIn")}</legend>
      <label class="row">
        <input type="radio" name="edit-target" checked={name === null} onChange={() => onName(null)} />
        {w("label.thisClip")}
      </label>
      <label class="row">
        <input
          type="radio"
          name="edit-target"
          checked={name !== null}
          onChange={() => onName(`${clip.detail.name}, ${title.toLocaleLowerCase()}`)}
        />
        {w("label.newClip")}
        <input
          class="field grow"
          aria-label={w("label.name")}
          disabled={name === null}
          maxLength={1024}
          value={name ?? ""}
          onInput={(event) => onName(event.currentTarget.value)}
        />
      </label>
    </fieldset>
  );
}
