/** How far the made motion is to be trusted: in words, with a sign, and which examples it is made of. */
import { entryOf } from "../../lists";
import { Icon } from "../../ui/icons";
import { number } from "../../words";
import type { Blending } from "./blending";
import { unseenOf, valuesOf, type Model } from "./model";
import { nameOf, unitOf } from "./names";
import { b } from "./words";

const MOST = 4;

export function Trust({ model, blending }: { model: Model; blending: Blending }) {
  const shown = blending.shown.value;
  if (!shown) return null;
  const { support, in_gaps, nn_ratio, weights, skeleton_source: near } = shown.answer;
  const unseen = unseenOf(model);
  const size = unseen?.hand == null ? "" : `${number(unseen.hand, 0)} ${model.summary.hand_unit}`;
  const known = support === "inside" && nn_ratio <= 2;
  const row = model.byId.get(near.document);
  const gap = model.attributes.find((one) => in_gaps.includes(one.name));
  const inGap = gap?.gaps.find(([low, high]) => {
    const value = entryOf(shown.answer.used_attributes, gap.name);
    return low < value && value < high;
  });
  const biggest = Math.abs(weights[0]?.weight ?? 1) || 1;
  return (
    <section class={`trust ${support}`} aria-label={b("label.trust")}>
      <p role="status">
        <strong class={`support ${support}`}>
          <Icon name={support === "inside" ? "check" : "warn"} />
          {b(`label.${support}Data`)}
        </strong>
        {size && <> · {b(known ? "label.aboutAtHand" : "label.moreAtHand", { size })}</>}
      </p>
      {gap && inGap && (
        <p>
          {b("help.gapWords", {
            low: number(inGap[0], 2),
            high: number(inGap[1], 2),
            name: nameOf(gap.name),
            unit: unitOf(gap.unit),
          })}
        </p>
      )}
      {support === "outside" && <p>{b("help.outsideWords")}</p>}
      {support === "inside" && nn_ratio > 2 && <p>{b("help.sparseWords", { times: number(nn_ratio, 1) })}</p>}
      {row && (
        <p class="dim">
          {b("label.nearestValues")}{" "}
          {model.attributes.map((one) => `${number(row[one.name] as number, 2)} ${unitOf(one.unit)}`).join(", ")}{" "}
          <button type="button" class="as-link" onClick={() => blending.set(valuesOf(model, row))}>
            {b("button.goThere")}
          </button>
        </p>
      )}
      <details>
        <summary>{b("label.madeOfExamples")}</summary>
        <ul class="weights">
          {weights.slice(0, MOST).map(({ clip, weight }) => (
            <li key={clip.document} class="bar-row">
              <a class="cut" href={`/clips/${clip.document}?rev=${clip.revision}`}>
                {model.byId.get(clip.document)?.name ?? clip.name}
              </a>
              <span class="meter">
                <span
                  class={weight < 0 ? "minus" : "model"}
                  style={{ width: `${(Math.abs(weight) / biggest) * 100}%` }}
                />
              </span>
              <span class="n">{number(weight, 2)}</span>
            </li>
          ))}
        </ul>
      </details>
    </section>
  );
}
