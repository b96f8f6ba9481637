/** Curves over the gait cycle, from strike to strike: mean and standard deviation of each side. */
import { useMemo } from "preact/hooks";
import type { Schemas } from "../../../api/client";
import { bandOf, type Pair } from "../../../motion/body/gait";
import { Plot, type Curve, type Mark } from "../../../ui/Plot";
import { w, type Word } from "../../../words";

type Measures = Schemas["GaitMeasures"];
const PERCENT = Array.from({ length: 101 }, (_, at) => at);
const PLANES: [string, Word][] = [
  ["x", "label.sagittal"],
  ["y", "label.frontal"],
  ["z", "label.transverse"],
];

export function Cycles({
  gait,
  pairs,
  axis,
  onAxis,
  ofFile,
}: {
  gait: Measures;
  pairs: readonly Pair[];
  axis: string;
  onAxis: (axis: string) => void;
  ofFile: boolean;
}) {
  return (
    <section>
      <h3 class="row wrap">
        {w("label.gaitCycles")}
        <span class="tail" />
        {ofFile && (
          <div class="segments" role="group" aria-label={w("label.plane")}>
            {PLANES.map(([each, word]) => (
              <button type="button" key={each} aria-pressed={axis === each} onClick={() => onAxis(each)}>
                {w(word)}
              </button>
            ))}
          </div>
        )}
      </h3>
      {ofFile && <p class="dim">{w("help.ownAnglesHelp")}</p>}
      {pairs.map((pair) => (
        <CycleOf key={pair.title} gait={gait} pair={pair} />
      ))}
    </section>
  );
}

function CycleOf({ gait, pair }: { gait: Measures; pair: Pair }) {
  const [left, right] = [pair.left, pair.right].map((quantity) =>
    gait.cycles.find((cycle) => cycle.quantity === quantity),
  );
  const curves = useMemo(
    () =>
      [left, right].flatMap((cycle): Curve[] => {
        if (!cycle || !cycle.n) return [];
        const name = w(cycle.side === "left" ? "label.sideLeft" : "label.sideRight");
        const band = { low: bandOf(cycle, -1), high: bandOf(cycle, 1) };
        return [{ name: `${name}, n = ${cycle.n}`, values: cycle.mean, ink: cycle.side, band }];
      }),
    [left, right],
  );
  const stance = gait.parameters.find((each) => each.name === "stance");
  const marks = useMemo(
    () =>
      (["left", "right"] as const).flatMap((side): Mark[] => {
        const at = stance?.[side].mean;
        return at === null || at === undefined ? [] : [{ at, ink: side, dash: [4, 4] }];
      }),
    [stance],
  );
  return (
    <div class="gait-cycle">
      <h4>{pair.title}</h4>
      {curves.length ? (
        <Plot
          x={PERCENT}
          curves={curves}
          marks={marks}
          label={`${w("label.gaitCycles")}: ${pair.title}`}
          xLabel={w("label.percentOfCycle")}
          yLabel={left?.unit ?? right?.unit}
          height={150}
        />
      ) : (
        <p class="dim">{w("error.noCycle")}</p>
      )}
    </div>
  );
}
