/** The measures of a standing trial, before walking trials take them. */
import { useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { number, w } from "../../words";
import { Chooser } from "../clips/ClipChooser";
import { Dialog } from "../Dialog";
import { Trouble } from "../Trouble";
import { useAsync } from "../useAsync";
import { g } from "./words";

type Measure = Schemas["StandingMeasure"];
type Foot = NonNullable<Schemas["StandingTrialUse"]["foot"]>;

const FEET = [
  ["", "label.footAuto"],
  ["flat", "label.footFlat"],
  ["as it stands", "label.footAsIs"],
] as const;

const SOURCES = {
  stated: "label.source_stated",
  markers: "label.source_markers",
  "alignment device": "label.source_device",
  "medial knee marker": "label.source_knee",
  "medial ankle marker": "label.source_ankle",
  "heel and toe": "label.source_foot",
} as const satisfies Record<Measure["source"], string>;

const DEGREES = 180 / Math.PI;
const MOST = 1000;

/** name: of the standing trial. trials: ids that take its measures; more can be chosen. onDone: they have. */
export function StandingTrialDialog({
  standing,
  name,
  trials,
  onClose,
  onDone,
}: {
  standing: string;
  name: string;
  trials: readonly string[];
  onClose: () => void;
  onDone: () => void;
}) {
  const [foot, setFoot] = useState<Foot | "">("");
  const [chosen, setChosen] = useState(trials);
  const [choosing, setChoosing] = useState(false);
  const [busy, setBusy] = useState(false);
  const measured = useAsync(
    (signal) => get("/documents/{id}/standing-trial", { path: { id: standing }, query: foot ? { foot } : {}, signal }),
    [standing, foot],
  );
  const apply = async () => {
    setBusy(true);
    try {
      const { items } = await ask("post", "/documents/{id}/standing-trial", {
        path: { id: standing },
        body: { selection: { documents: [...chosen], property: [], include_made: false }, foot: foot || null },
      });
      const detail = items.flatMap((one) => one.notes.map((text) => `${one.name}: ${text}`)).join(" ");
      note(g("label.measuresUsed", { n: items.length }), detail ? { detail } : {});
      onDone();
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  const toggle = (id: string) =>
    setChosen(chosen.includes(id) ? chosen.filter((other) => other !== id) : [...chosen, id]);
  return (
    <Dialog title={g("label.standingOf", { name })} onClose={onClose} wide>
      <div class="skeletons">
        <p class="dim">{g("help.standingTrial")}</p>
        <Trouble error={measured.error} />
        {measured.busy && !measured.value && <div class="busy" />}
        {measured.value && <Measures trial={measured.value} />}
        <div class="row wrap">
          <label class="row" title={g("help.footTaken")}>
            {g("label.footTaken")}
            <select class="field" value={foot} onChange={(event) => setFoot(event.currentTarget.value as Foot | "")}>
              {FEET.map(([value, word]) => (
                <option key={value} value={value}>
                  {g(word)}
                </option>
              ))}
            </select>
          </label>
          <button type="button" class="button" onClick={() => setChoosing(true)}>
            {g("button.chooseTrials")}
          </button>
          <span>{g("label.trialsChosen", { n: chosen.length })}</span>
        </div>
        <div class="row export-done">
          <p class="grow dim">{g("help.bodyMeasuresStay")}</p>
          <button
            type="button"
            class="button primary"
            disabled={busy || !measured.value || !chosen.length}
            onClick={() => void apply()}
          >
            {busy ? w("label.loading") : g("button.useMeasures", { n: chosen.length })}
          </button>
        </div>
      </div>
      {choosing && (
        <Chooser
          title={g("button.chooseTrials")}
          chosen={chosen}
          most={MOST}
          without={standing}
          onClose={() => setChoosing(false)}
          onChoose={toggle}
        />
      )}
    </Dialog>
  );
}

function Measures({ trial }: { trial: Schemas["StandingTrial"] }) {
  const rows = rowsOf(trial.measures);
  return (
    <>
      <div class="gait-scroll standing-measures" tabIndex={0} role="region" aria-label={g("label.measures")}>
        <table class="gait-table">
          <thead>
            <tr>
              <th>{g("label.measure")}</th>
              <th class="n" data-side="left">
                {w("label.sideLeft")}
              </th>
              <th class="n" data-side="right">
                {w("label.sideRight")}
              </th>
              <th>{g("label.source")}</th>
            </tr>
          </thead>
          <tbody>
            {[...rows].map(([name, { left, right, both }]) => (
              <tr key={name}>
                <td>{name}</td>
                {both ? (
                  <td class="of-both" colSpan={2}>
                    {shown(both)}
                  </td>
                ) : (
                  <>
                    <td class="n">{left && shown(left)}</td>
                    <td class="n">{right && shown(right)}</td>
                  </>
                )}
                <td class="dim">{sources(both, left, right)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {trial.virtual.length > 0 && (
        <p title={g("help.virtualMarkers")}>
          {g("label.virtualMarkers", { names: trial.virtual.map((one) => one.name).join(", ") })}
        </p>
      )}
      {trial.notes.length > 0 && (
        <ul class="dim">
          {trial.notes.map((text) => (
            <li key={text}>{text}</li>
          ))}
        </ul>
      )}
    </>
  );
}

interface Row {
  left?: Measure;
  right?: Measure;
  /** Of no side. */
  both?: Measure;
}

const SIDED = /^[LR](?=[A-Z])/;

/** Measures of both sides in one row, by the name without the side. */
function rowsOf(measures: readonly Measure[]): Map<string, Row> {
  const rows = new Map<string, Row>();
  for (const one of measures) {
    const name = one.name.replace(SIDED, "");
    const place = name === one.name ? "both" : one.name.startsWith("L") ? "left" : "right";
    rows.set(name, { ...rows.get(name), [place]: one });
  }
  return rows;
}

const sources = (...measures: readonly (Measure | undefined)[]): string =>
  [...new Set(measures.flatMap((one) => (one ? [g(SOURCES[one.source])] : [])))].join(", ");

const shown = ({ value, unit }: Measure): string =>
  unit === "rad" ? `${number(value * DEGREES, 2)}°` : `${number(value, 1)} ${unit}`;
