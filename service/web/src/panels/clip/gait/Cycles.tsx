/** Curves over the gait cycle, from strike to strike: mean and standard deviation of each side. */
import { useMemo } from "preact/hooks";
import type { Schemas } from "../../../api/client";
import { bandOf, meanOf, type Model, type Pair } from "../../../motion/body/gait";
import { g } from "../../../ui/gait/words";
import { Plot, type Curve, type Mark } from "../../../ui/Plot";
import { w, type Word } from "../../../words";

import type { Compared } from "./Comparing";

type Measures = Schemas["GaitMeasures"];
const PERCENT = Array.from({ length: 101 }, (_, at) => at);
const MODELS = [
  ["stated", "label.ofLaboratory"],
  ["computed", "label.computedAngles"],
] as const;
const PLANES: [string, Word][] = [
  ["x", "label.sagittal"],
  ["y", "label.frontal"],
  ["z", "label.transverse"],
];

interface Choice<T extends string> {
  value: T;
  choose: (value: T) => void;
}

/** model: where the file has angles of its laboratory, and others are computed beside. */
export function Cycles({
  gait,
  compared,
  pairs,
  plane,
  model,
  how,
  ofFile,
}: {
  gait: Measures;
  compared: Compared | null;
  pairs: readonly Pair[];
  plane: Choice<string>;
  model: Choice<Model> | null;
  how: string;
  ofFile: boolean;
}) {
  return (
    <section>
      <h3 class="row wrap">
        {w("label.gaitCycles")}
        <span class="tail" />
        {model && <Segments label={g("label.anglesFrom")} of={MODELS} choice={model} word={g} />}
        {ofFile && <Segments label={w("label.plane")} of={PLANES} choice={plane} word={w} />}
      </h3>
      {ofFile && <p class="dim">{how ? w("help.computedAnglesHelp", { how }) : w("help.ownAnglesHelp")}</p>}
      {pairs.map((pair) => (
        <CycleOf key={pair.title} gait={gait} compared={compared} pair={pair} />
      ))}
    </section>
  );
}

function Segments<T extends string, Key>({
  label,
  of,
  choice,
  word,
}: {
  label: string;
  of: readonly (readonly [T, Key])[];
  choice: Choice<T>;
  word: (key: Key) => string;
}) {
  return (
    <div class="segments" role="group" aria-label={label}>
      {of.map(([each, key]) => (
        <button type="button" key={each} aria-pressed={choice.value === each} onClick={() => choice.choose(each)}>
          {word(key)}
        </button>
      ))}
    </div>
  );
}

type Cycle = Schemas["GaitCycle"];

const cyclesOf = (cycles: readonly Cycle[] | undefined, { left, right }: Pair): Cycle[] =>
  [left, right].flatMap((quantity, at) => {
    const side = at ? "right" : "left";
    const found = cycles?.find((cycle) => cycle.quantity === quantity && cycle.side === side && cycle.n);
    return found ? [found] : [];
  });

const sideOf = (cycle: Cycle) => w(cycle.side === "left" ? "label.sideLeft" : "label.sideRight");

/** The normal band, then both sides, then those of the other trials as dashed lines. */
function curvesOf(gait: Measures, compared: Compared | null, pair: Pair): Curve[] {
  const normal = cyclesOf(compared?.reference?.cycles, pair);
  const middle = normal.length ? meanOf(normal) : null;
  return [
    ...(middle
      ? [
          {
            name: `${w("label.normalBand")}, n = ${middle.n}`,
            values: middle.mean,
            ink: "text3",
            width: 0.8,
            band: { low: bandOf(middle, -1), high: bandOf(middle, 1) },
          },
        ]
      : []),
    ...cyclesOf(gait.cycles, pair).map((cycle) => ({
      name: `${sideOf(cycle)}, n = ${cycle.n}`,
      values: cycle.mean,
      ink: cycle.side,
      band: { low: bandOf(cycle, -1), high: bandOf(cycle, 1) },
    })),
    ...cyclesOf(compared?.compare?.cycles, pair).map((cycle) => ({
      name: `${w("label.compared")}: ${sideOf(cycle)}, n = ${cycle.n}`,
      values: cycle.mean,
      ink: cycle.side,
      dash: [5, 3],
    })),
  ];
}

function CycleOf({ gait, compared, pair }: { gait: Measures; compared: Compared | null; pair: Pair }) {
  const curves = useMemo(() => curvesOf(gait, compared, pair), [gait, compared, pair]);
  const unit = cyclesOf(gait.cycles, pair)[0]?.unit;
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
          yLabel={unit}
          height={150}
        />
      ) : (
        <p class="dim">{w("error.noCycle")}</p>
      )}
    </div>
  );
}
