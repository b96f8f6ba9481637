/** Spatio-temporal parameters by side. */
import type { Schemas } from "../../../api/client";
import { itemAt } from "../../../lists";
import { number, w, type Word } from "../../../words";
import type { Compared } from "./Comparing";

const SIDES = [
  ["left", "label.sideLeft"],
  ["right", "label.sideRight"],
] as const;

const WORDS: Record<string, Word> = {
  stride_time: "label.strideTime",
  step_time: "label.stepTime",
  cadence: "label.cadence",
  stride_length: "label.strideLength",
  step_length: "label.stepLength",
  step_width: "label.stepWidth",
  speed: "label.quantitySpeed",
  stance: "label.stance",
  double_support: "label.doubleSupport",
  single_support: "label.singleSupport",
};

const GROUPS = [
  ["compare", "label.compared"],
  ["reference", "label.normalBand"],
] as const;

export function Parameters({ gait, compared }: { gait: Schemas["GaitMeasures"]; compared: Compared | null }) {
  const groups = GROUPS.flatMap(([name, word]) => {
    const group = compared?.[name];
    return group ? [{ name, word, parameters: group.parameters }] : [];
  });
  return (
    <div class="gait-scroll">
      <table class="gait-table">
        <thead>
          <tr>
            <th>{w("label.gaitParameter")}</th>
            <th class="n" data-side="left">
              {w("label.sideLeft")}
            </th>
            <th class="n" data-side="right">
              {w("label.sideRight")}
            </th>
            <th class="n" title={w("help.symmetryHelp")}>
              {w("label.symmetry")}
            </th>
            {groups.map(({ name, word }) =>
              SIDES.map(([side, label]) => (
                <th key={name + side} class="n" data-side={side}>
                  {w(word)}: {w(label)}
                </th>
              )),
            )}
          </tr>
        </thead>
        <tbody>
          {gait.parameters.map((each, at) => (
            <tr key={each.name} title={each.how}>
              <td>
                {WORDS[each.name] ? w(WORDS[each.name] as Word) : each.name} <span class="dim">{each.unit}</span>
              </td>
              <Value {...each.left} />
              <Value {...each.right} />
              <td class="n">{each.symmetry === null ? "–" : `${number(each.symmetry, 2)} %`}</td>
              {groups.map(({ name, parameters }) =>
                SIDES.map(([side]) => <Value key={name + side} {...itemAt(parameters, at)[side]} />),
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Value({ mean, sd, n }: Schemas["GaitSummary"]) {
  return (
    <td class="n" title={w("label.strides", { n })}>
      {mean === null ? "–" : number(mean, 3)}
      {mean !== null && sd !== null && <span class="dim"> ± {number(sd, 2)}</span>}
    </td>
  );
}
