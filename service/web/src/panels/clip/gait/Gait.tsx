/** The gait of a clip: parameters by side, cycles of the joints, and the events that they rest on. */
import { useMemo, useState } from "preact/hooks";
import { get, type Schemas } from "../../../api/client";
import { hasBothModels, howComputed, pairsOf, type Model, type Pair } from "../../../motion/body/gait";
import type { Clip } from "../../../state/clip/clip";
import { mayEdit } from "../../../state/session/me";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";
import { newSpan } from "../actions";
import { useMeasurements } from "../body/useMeasurements";
import { Comparing, useCompared, type Others } from "./Comparing";
import { Cycles } from "./Cycles";
import { Parameters } from "./Parameters";
import { StandingTrial } from "./StandingTrial";

const SOURCES = { label: "label.fromLabel", plate: "label.fromPlate", positions: "label.fromPositions" } as const;

export type Measures = Schemas["GaitMeasures"];

export function Gait({ clip, reload }: { clip: Clip; reload: () => void }) {
  const [axis, setAxis] = useState("x");
  const [model, setModel] = useState<Model>("stated");
  const [others, setOthers] = useState<Others>({ compare: "", reference: "" });
  const listed = useMeasurements(clip);
  const items = listed.value?.items;
  const pairs = useMemo(
    () => items && pairsOf(items, axis, clip.skeleton.view.markers, model),
    [items, axis, clip, model],
  );
  const loaded = useAsync(
    async (signal) => {
      if (!pairs) return null;
      const query = { revision: clip.detail.revision, quantity: quantitiesOf(pairs) };
      return await get("/documents/{id}/gait", { path: { id: clip.id }, query, signal });
    },
    [clip, pairs],
  );
  const gait = loaded.value;
  const compared = useCompared(clip, others, quantitiesOf(pairs));
  return (
    <div class="gait">
      <StandingTrial clip={clip} reload={reload} />
      <Trouble error={listed.error ?? loaded.error ?? compared.error} retry={loaded.again} />
      {loaded.busy && !gait && <div class="busy" />}
      {gait && (
        <>
          <Summary gait={gait} />
          <Comparing clip={clip} others={others} choose={setOthers} />
          <Parameters gait={gait} compared={compared.value ?? null} />
          {items && pairs && pairs.length > 0 && (
            <Cycles
              gait={gait}
              compared={compared.value ?? null}
              pairs={pairs}
              plane={{ value: axis, choose: setAxis }}
              model={hasBothModels(items) ? { value: model, choose: setModel } : null}
              how={howComputed(items, pairs)}
              ofFile={Boolean(pairs[0]?.left.startsWith("quantity:"))}
            />
          )}
          <Events clip={clip} gait={gait} />
        </>
      )}
    </div>
  );
}

const quantitiesOf = (pairs: readonly Pair[] = []): string[] => pairs.flatMap((pair) => [pair.left, pair.right]);

function Summary({ gait }: { gait: Measures }) {
  const kind = gait.running === null ? "" : w(gait.running ? "label.running" : "label.walking");
  const belt =
    gait.belt.is_belt && gait.belt.speed !== null ? w("label.onBelt", { speed: number(gait.belt.speed, 3) }) : "";
  return (
    <>
      <div class="row wrap">
        <strong>{[kind, belt].filter(Boolean).join(", ")}</strong>
        <span class="dim">{w("label.strides", { n: gait.strides.length })}</span>
      </div>
      {gait.warnings.length > 0 && (
        <details>
          <summary>{w("label.warnings", { n: gait.warnings.length })}</summary>
          <ul class="gait-warnings">
            {gait.warnings.map((text) => (
              <li key={text}>{text}</li>
            ))}
          </ul>
        </details>
      )}
    </>
  );
}

/** Events with their sources; a press shows the frame. */
function Events({ clip, gait }: { clip: Clip; gait: Measures }) {
  const isFound = (event: Measures["events"][number]) => event.source !== "label";
  const found = gait.events.filter(isFound);
  const add = () =>
    clip.setLabels([
      ...clip.labels.peek(),
      ...found.map(({ side, kind, frame }) => newSpan(`${side}-foot-${kind}`, frame, frame)),
    ]);
  return (
    <section>
      <h3 class="row">
        {w("label.gaitEvents", { n: gait.events.length })}
        <span class="tail" />
        {found.length > 0 && clip.pinned === null && mayEdit() && (
          <button type="button" class="button dense" title={w("help.addEventsHelp")} onClick={add}>
            {w("button.addEvents")}
          </button>
        )}
      </h3>
      <div class="gait-events">
        {gait.events.map((event) => (
          <button
            type="button"
            key={`${event.side}${event.kind}${event.time}`}
            class="chip"
            data-side={event.side}
            title={`${w(event.side === "left" ? "label.sideLeft" : "label.sideRight")}, ${w(SOURCES[event.source])}`}
            onClick={() => clip.player.seek(event.frame - 1)}
          >
            {w(event.kind === "strike" ? "label.footStrike" : "label.footOff")} {number(event.time, 3)} s
          </button>
        ))}
      </div>
    </section>
  );
}
