/** The parameters of an edit of frames. */
import { NumberField } from "../../../ui/forms/NumberField";
import { w } from "../../../words";
import { isSeen, LEAST_FACTOR, MOST_FACTOR, type Choices, type Kind } from "./edits";

const PLACES = ["label.speedStart", "label.speedMiddle", "label.speedEnd"] as const;

interface Editing {
  kind: Kind;
  choices: Choices;
  onChange: (more: Partial<Choices>) => void;
}

/** selected: number of selected joints, to which repairs can be limited. */
export function EditFields({ selected, ...editing }: Editing & { selected: number }) {
  const { kind, choices, onChange } = editing;
  return (
    <>
      <Parameters {...editing} />
      {selected > 0 && !isSeen(kind) && kind !== "lock-feet" && (
        <label class="row">
          <input
            type="checkbox"
            checked={choices.selected}
            onChange={(event) => onChange({ selected: event.currentTarget.checked })}
          />
          {w("label.cleanSelected", { n: selected })}
        </label>
      )}
    </>
  );
}

function Parameters({ kind, choices, onChange }: Editing) {
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
  return kind === "speed" ? <Factors factors={choices.factors} onChange={(factors) => onChange({ factors })} /> : null;
}

/** One factor, or a curve of three. */
function Factors({
  factors,
  onChange,
}: {
  factors: Choices["factors"];
  onChange: (factors: Choices["factors"]) => void;
}) {
  const set = (at: number, value: number | null) => {
    const factor = Math.min(MOST_FACTOR, Math.max(LEAST_FACTOR, value ?? 1));
    // While all are the same, the first one decides all.
    const all = at === 0 && factors.every((one) => one === factors[0]);
    onChange(factors.map((one, place) => (all || place === at ? factor : one)) as Choices["factors"]);
  };
  return (
    <div class="row wrap factors">
      {PLACES.map((place, at) => (
        <label key={place} class="row">
          {w(place)}
          <NumberField
            value={factors[at] ?? 1}
            least={LEAST_FACTOR}
            most={MOST_FACTOR}
            step={0.05}
            onChange={(value) => set(at, value)}
          />
        </label>
      ))}
    </div>
  );
}
