/** Gaps, noise, spikes, angles that leap, feet that slide, loops: chosen, previewed by what would change, then made. */
import { useEffect, useState } from "preact/hooks";
import { startCurve, type CurveName } from "../../../motion/timeline/comparing";
import type { Clip } from "../../../state/clip/clip";
import { Dialog } from "../../../ui/Dialog";
import { NumberField } from "../../../ui/forms/NumberField";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w } from "../../../words";
import { CurvePreview } from "./CurvePreview";
import { editFrames, previewEdits, type Edits } from "./editFrames";

const KINDS = ["fill", "despike", "low-pass", "unroll", "lock-feet", "loop"] as const;
type Kind = (typeof KINDS)[number];
const TITLES = {
  fill: "label.cleanFill",
  despike: "label.cleanDespike",
  "low-pass": "label.cleanLowPass",
  unroll: "label.cleanUnroll",
  "lock-feet": "label.cleanLockFeet",
  loop: "label.cleanLoop",
} as const;
const HELP = {
  fill: "help.cleanFill",
  despike: "help.cleanDespike",
  "low-pass": "help.cleanLowPass",
  unroll: "help.cleanUnroll",
  "lock-feet": "help.cleanLockFeet",
  loop: "help.cleanLoop",
} as const;
const WAIT = 300; // ms after the last change

interface Choices {
  longest: number;
  deviations: number;
  /** null: by the motion itself. */
  hertz: number | null;
  inPlace: boolean;
  selected: boolean;
}

/** The edit that the choices ask for. */
function editOf(
  kind: Kind,
  { longest, deviations, hertz, inPlace, selected }: Choices,
  clip: Clip,
  span: [number, number],
) {
  const [first, last] = span;
  const bones = selected ? [...clip.selection.peek().bones] : [];
  const edits = {
    fill: { do: kind, first, last, longest, bones },
    despike: { do: kind, first, last, deviations, bones },
    "low-pass": { do: kind, first, last, bones, ...(hertz ? { hertz } : {}) },
    unroll: { do: kind, bones },
    "lock-feet": { do: kind, first, last },
    loop: { do: kind, first, last, in_place: inPlace },
  };
  return [edits[kind]] as unknown as Edits;
}

/** The dry run of edits, with a curve: the chosen one, else of the selected joint, else of the one with the most new samples. */
function usePreview(clip: Clip, edits: Edits) {
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
      return previewEdits(clip, edits, curve, signal);
    },
    [JSON.stringify([edits, curve])],
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
  reload,
  onClose,
}: {
  clip: Clip;
  range: [number, number] | null;
  reload: () => void;
  onClose: () => void;
}) {
  const [kind, setKind] = useState<Kind>("fill");
  const some = clip.selection.value.bones.length;
  const [choices, setChoices] = useState<Choices>({
    longest: 1,
    deviations: 6,
    hertz: null,
    inPlace: false,
    selected: some > 0,
  });
  const span = range ?? [1, clip.frames];
  const edits = editOf(kind, choices, clip, span);
  const { preview, made, curve, choose } = usePreview(clip, edits);
  const change = (more: Partial<Choices>) => setChoices({ ...choices, ...more });
  return (
    <Dialog title={w("button.repairFrames")} onClose={onClose}>
      <form
        class="clean-up"
        onSubmit={(event) => {
          event.preventDefault();
          onClose();
          void editFrames(clip, reload, edits);
        }}
      >
        <label class="row">
          {w("label.cleanKind")}
          <select class="field" value={kind} onChange={(event) => setKind(event.currentTarget.value as Kind)}>
            {KINDS.map((one) => (
              <option key={one} value={one}>
                {w(TITLES[one])}
              </option>
            ))}
          </select>
        </label>
        <p class="dim">{w(HELP[kind])}</p>
        <Fields kind={kind} choices={choices} onChange={change} />
        {some > 0 && kind !== "lock-feet" && kind !== "loop" && (
          <label class="row">
            <input
              type="checkbox"
              checked={choices.selected}
              onChange={(event) => change({ selected: event.currentTarget.checked })}
            />
            {w("label.cleanSelected", { n: some })}
          </label>
        )}
        <p>{kind === "unroll" ? w("label.cleanAll") : w("label.cleanRange", { first: span[0], last: span[1] })}</p>
        <Trouble error={preview.error} />
        <ul class="clean-notes" role="status" aria-busy={preview.busy} aria-label={w("label.preview")}>
          {made?.notes.map((one) => (
            <li key={one}>{one}</li>
          ))}
          {preview.busy && <li class="busy" />}
        </ul>
        {curve && !preview.error && (
          <CurvePreview clip={clip} made={made} busy={preview.busy} chosen={curve} choose={choose} />
        )}
        <div class="row">
          <span class="grow" />
          <button type="submit" class="button primary" disabled={preview.busy || Boolean(preview.error)}>
            {w("button.apply")}
          </button>
        </div>
      </form>
    </Dialog>
  );
}

function Fields({
  kind,
  choices,
  onChange,
}: {
  kind: Kind;
  choices: Choices;
  onChange: (more: Partial<Choices>) => void;
}) {
  if (kind === "fill")
    return (
      <label class="row">
        {w("label.cleanLongest")}
        <NumberField
          value={choices.longest}
          least={0}
          most={60}
          onChange={(value) => onChange({ longest: value ?? 1 })}
        />
      </label>
    );
  if (kind === "despike")
    return (
      <label class="row">
        {w("label.cleanDeviations")}
        <NumberField
          value={choices.deviations}
          least={1}
          most={1000}
          onChange={(value) => onChange({ deviations: value ?? 6 })}
        />
      </label>
    );
  if (kind === "low-pass")
    return (
      <label class="row">
        {w("label.cleanHertz")}
        <NumberField
          value={choices.hertz}
          least={0.1}
          placeholder={w("label.cleanAutomatic")}
          onChange={(value) => onChange({ hertz: value })}
        />
      </label>
    );
  if (kind === "loop")
    return (
      <label class="row">
        <input
          type="checkbox"
          checked={choices.inPlace}
          onChange={(event) => onChange({ inPlace: event.currentTarget.checked })}
        />
        {w("label.cleanInPlace")}
      </label>
    );
  return null;
}
