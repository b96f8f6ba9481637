/** How a motion is put on a body, with what each choice means. */
import { NumberField } from "../../ui/forms/NumberField";
import { number, w, type Word } from "../../words";

export interface Choices {
  clean_feet: boolean;
  match_rest: boolean;
  /** null: by the legs. */ scale: number | null;
}
export const USUAL: Choices = { clean_feet: false, match_rest: false, scale: null };

export function Options({
  choices,
  fitted,
  onChange,
}: {
  choices: Choices;
  /** The scale that came out. */ fitted: number | undefined;
  onChange: (choices: Choices) => void;
}) {
  const changed = choices.clean_feet || choices.match_rest || choices.scale !== null;
  const check = (name: "clean_feet" | "match_rest", word: Word, help: Word) => (
    <label class="option">
      <input
        type="checkbox"
        checked={choices[name]}
        onChange={(event) => onChange({ ...choices, [name]: event.currentTarget.checked })}
      />
      <span>
        {w(word)}
        <span class="dim block">{w(help)}</span>
      </span>
    </label>
  );
  return (
    <details class="options" open={changed || undefined}>
      <summary>
        <h2>{w("label.options")}</h2>{" "}
        <span class="dim">{w("label.scaleOf", { value: fitted === undefined ? "–" : number(fitted, 3) })}</span>
      </summary>
      {check("clean_feet", "label.cleanFeet", "help.cleanFeetHelp")}
      {check("match_rest", "label.matchRest", "help.matchRestHelp")}
      <div class="option">
        <input
          type="checkbox"
          id="own-scale"
          checked={choices.scale !== null}
          disabled={choices.scale === null && fitted === undefined}
          onChange={(event) =>
            onChange({ ...choices, scale: event.currentTarget.checked ? Number((fitted ?? 1).toPrecision(4)) : null })
          }
        />
        <span>
          <label for="own-scale">{w("label.ownScale")}</label>
          {choices.scale !== null && (
            <NumberField
              label={w("label.ownScale")}
              least={0.0001}
              value={choices.scale}
              onChange={(scale) => scale !== null && scale > 0 && onChange({ ...choices, scale })}
            />
          )}
          <span class="dim block">{w("help.ownScaleHelp")}</span>
        </span>
      </div>
    </details>
  );
}
