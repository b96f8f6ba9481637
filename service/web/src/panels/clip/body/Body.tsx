/** What can be asked of a body in motion, as a curve over the clip; a threshold on it writes the question. */
import { useMemo, useState } from "preact/hooks";
import { quantityOf } from "../../../motion/loading/blocks";
import {
  countHits,
  expression,
  isOfFile,
  known,
  rounded,
  startOf,
  textOf,
  type Asked,
} from "../../../motion/body/quantities";
import type { Clip } from "../../../state/clip/clip";
import { go, param, setParams } from "../../../state/session/route";
import { MeasurementChoice } from "../../../ui/clips/MeasurementChoice";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";
import { Curve } from "./BodyCurve";
import { Calibrated } from "./Calibration";
import { useMeasured } from "./useMeasurements";
import { NoMeasurement, Unknown } from "./UnknownMeasure";

export function Body({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { centres, bones: joints } = clip.skeleton.view;
  const bones = [...centres, ...joints.map((bone) => bone.name)];
  const asked = startOf(param("quantity"), clip.selection.value.bones[0], bones);
  const text = textOf(asked);
  const choose = (next: Asked) => setParams({ quantity: textOf(next) });
  const curve = useAsync((signal) => quantityOf(clip.id, clip.detail.revision, text, signal), [clip, text]);
  const { measured, unit, reason } = useMeasured(clip, asked);
  const [limit, setLimit] = useState<{ of: string; at: number; above: boolean } | null>(null);
  const values = curve.value;
  const span = useMemo(() => (values ? known(values) : null), [values]);
  const mine = limit?.of === text ? limit : span && { of: text, at: rounded((span.low + span.high) / 2), above: true };
  const question = mine && expression(asked, mine.at, mine.above);
  const hits = values && mine ? countHits(values, asked.kind, mine.at, mine.above) : 0;
  const search = (q: string) => go(`/xpath?q=${encodeURIComponent(q)}`);
  return (
    <div class="graph">
      <div class="row wrap graph-tools">
        <MeasurementChoice asked={asked} bones={bones} measured={measured} choose={choose} />
      </div>
      <Trouble error={curve.error} retry={curve.again} />
      {curve.busy && !values && <div class="busy" />}
      {values &&
        !span &&
        (isOfFile(asked.kind) ? (
          <NoMeasurement reason={reason} />
        ) : (
          <Unknown clip={clip} kind={asked.kind} reload={reload} />
        ))}
      {values && span && mine && (
        <Curve
          clip={clip}
          values={values}
          label={text}
          unit={unit}
          limit={asked.kind === "contact" ? null : mine.at}
          above={mine.above}
          onLimit={(at) => setLimit({ ...mine, at })}
        />
      )}
      {values && span && mine && question && (
        <div class="curve-tools" role="group" aria-label={w("label.quantityAsk")}>
          <span class="row wrap">
            {asked.kind !== "contact" && (
              <div class="segments" role="group" aria-label={w("label.threshold")}>
                <button type="button" aria-pressed={mine.above} onClick={() => setLimit({ ...mine, above: true })}>
                  {w("label.above")}
                </button>
                <button type="button" aria-pressed={!mine.above} onClick={() => setLimit({ ...mine, above: false })}>
                  {w("label.below")}
                </button>
              </div>
            )}
            {asked.kind !== "contact" && (
              <label class="row">
                <input
                  class="field number"
                  type="number"
                  step="any"
                  aria-label={w("label.threshold")}
                  value={mine.at}
                  onChange={(event) => {
                    const at = Number(event.currentTarget.value);
                    if (event.currentTarget.value !== "" && Number.isFinite(at)) setLimit({ ...mine, at });
                  }}
                />
                <span class="dim">{unit}</span>
              </label>
            )}
            <span class="dim" role="status">
              {w("label.framesFound", { n: hits, all: number(clip.frames) })}
            </span>
          </span>
          <span class="row wrap code-line">
            <code>{question}</code>
            <button type="button" class="button primary dense" onClick={() => search(question)}>
              {w("button.askLibrary")}
            </button>
          </span>
        </div>
      )}
      <Calibrated clip={clip} reload={reload} />
    </div>
  );
}
