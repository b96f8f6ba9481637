/** Spatio-temporal parameters by side. */
import type { Schemas } from "../../../api/client";
import { number, w, type Word } from "../../../words";

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

export function Parameters({ gait }: { gait: Schemas["GaitMeasures"] }) {
  return (
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
        </tr>
      </thead>
      <tbody>
        {gait.parameters.map((each) => (
          <tr key={each.name} title={each.how}>
            <td>
              {WORDS[each.name] ? w(WORDS[each.name] as Word) : each.name} <span class="dim">{each.unit}</span>
            </td>
            <Value {...each.left} />
            <Value {...each.right} />
            <td class="n">{each.symmetry === null ? "–" : `${number(each.symmetry, 2)} %`}</td>
          </tr>
        ))}
      </tbody>
    </table>
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
