/** How a motion is put on a body, with what each choice means. */
import { param } from "../../state/session/route";
import { NumberField } from "../../ui/forms/NumberField";
import { number, w, type Word } from "../../words";

export interface Choices {
  clean_feet: boolean;
  match_rest: boolean;
  keep_hands: boolean;
  limits: "file" | null;
  /** On the ground; null: by the legs. */ travel_scale: number | null;
}
const USUAL: Choices = {
  clean_feet: false,
  match_rest: false,
  keep_hands: false,
  limits: null,
  travel_scale: null,
};

/** Choices as the address of the page has them. */
export const paramsOf = (choices: Choices) => ({
  feet: choices.clean_feet ? "1" : null,
  rest: choices.match_rest ? "1" : null,
  hands: choices.keep_hands ? "1" : null,
  limits: choices.limits,
  travel: choices.travel_scale === null ? null : String(choices.travel_scale),
});

export const readChoices = (): Choices => ({
  clean_feet: param("feet") === "1",
  match_rest: param("rest") === "1",
  keep_hands: param("hands") === "1",
  limits: param("limits") === "file" ? "file" : null,
  travel_scale: Number(param("travel")) > 0 ? Number(param("travel")) : null,
});

export function Options({
  choices,
  fitted,
  onChange,
}: {
  choices: Choices;
  /** The scale that came out. */ fitted: number | undefined;
  onChange: (choices: Choices) => void;
}) {
  const changed = JSON.stringify(choices) !== JSON.stringify(USUAL);
  const check = (name: "clean_feet" | "match_rest" | "keep_hands", word: Word, help: Word) => (
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
      {check("keep_hands", "label.keepHands", "help.keepHandsHelp")}
      {check("match_rest", "label.matchRest", "help.matchRestHelp")}
      <label class="option">
        <input
          type="checkbox"
          checked={choices.limits !== null}
          onChange={(event) => onChange({ ...choices, limits: event.currentTarget.checked ? "file" : null })}
        />
        <span>
          {w("label.jointLimits")}
          <span class="dim block">{w("help.jointLimitsHelp")}</span>
        </span>
      </label>
      <div class="option">
        <input
          type="checkbox"
          id="own-scale"
          checked={choices.travel_scale !== null}
          disabled={choices.travel_scale === null && fitted === undefined}
          onChange={(event) =>
            onChange({
              ...choices,
              travel_scale: event.currentTarget.checked ? Number((fitted ?? 1).toPrecision(4)) : null,
            })
          }
        />
        <span>
          <label for="own-scale">{w("label.ownScale")}</label>
          {choices.travel_scale !== null && (
            <NumberField
              label={w("label.ownScale")}
              least={0.0001}
              value={choices.travel_scale}
              onChange={(scale) => scale !== null && scale > 0 && onChange({ ...choices, travel_scale: scale })}
            />
          )}
          <span class="dim block">{w("help.ownScaleHelp")}</span>
        </span>
      </div>
    </details>
  );
}
