/** What an import found in a file, with guesses that can be confirmed. */
import { useState } from "preact/hooks";
import { get, type Schemas } from "../../../api/client";
import { itemAt } from "../../../lists";
import { FACTS, ORIGINS, shownValue, type Fact } from "../../../motion/body/calibration";
import { confirmFact } from "../../../state/importing/uploads";
import { Icon } from "../../../ui/icons";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";

type Receipt = Schemas["Receipt"];
type Naming = Schemas["Naming"];

/** The kind of skeleton of markers. */
const MARKERS = "markers";

/** A joint whose name is less sure is a guess. */
const DOUBTFUL = 0.7;
const UNITS = ["cm", "mm", "m", "inch"];
const AXES = ["Y", "Z"];

/** What an import found, guessed and mended. documents: where answers are written; none: nothing is stored. */
export function ReceiptView({ receipt, documents }: { receipt: Receipt; documents: string[] }) {
  const [said, setSaid] = useState<{ unit?: string; up?: string }>({});
  const choose = async (change: { unit?: string; up?: string }) => {
    if (await confirmFact(documents, change)) setSaid({ ...said, ...change });
  };
  const fact = (
    name: "unit" | "up",
    one: { value?: string | null; stated: boolean; why: string },
    options: string[],
  ) => {
    const value = said[name] ?? one.value;
    return (
      <>
        <dd>
          {value ? (
            <span class={one.stated || said[name] ? "" : "guess"}>{value}</span>
          ) : (
            <span class="guess">{w(name === "unit" ? "label.unitUnknown" : "label.upUnknown")}</span>
          )}{" "}
          <span class="dim">{one.why}</span>
        </dd>
        <dd class="row">
          {!one.stated &&
            !said[name] &&
            documents.length > 0 &&
            options.map((option) => (
              <button key={option} type="button" class="button dense" onClick={() => void choose({ [name]: option })}>
                {option}
              </button>
            ))}
          {(one.stated || said[name]) && <Icon name="check" />}
        </dd>
      </>
    );
  };
  const { naming } = receipt;
  return (
    <dl class="receipt">
      <dt>{w("label.receiptUnit")}</dt>
      {fact("unit", receipt.unit, UNITS)}
      <dt>{w("label.receiptRate")}</dt>
      <dd>
        {receipt.frame_rate.frames_per_second
          ? `${number(receipt.frame_rate.frames_per_second, 4)} Hz`
          : w("label.rateUnknown")}{" "}
        <span class="dim">{receipt.frame_rate.why}</span>
      </dd>
      <dd>{receipt.frame_rate.stated && <Icon name="check" />}</dd>
      <dt>{w("label.receiptUp")}</dt>
      {fact("up", receipt.up_axis, AXES)}
      {documents.length > 0 && <CalibrationRow id={itemAt(documents, 0)} said={said} />}
      {naming && <NamingRow naming={naming} joints={receipt.joints} />}
      <dt>{w("label.receiptNumbers")}</dt>
      <dd>
        {w("label.receiptNumbersText", { channels: receipt.channels, frames: receipt.frames })}
        {receipt.twins.length > 0 && <p class="dim">{w("help.twin")}</p>}
      </dd>
      <dd />
      {receipt.notices.length > 0 && (
        <>
          <dt>{w("label.notices")}</dt>
          <dd>
            <ul>
              {receipt.notices.slice(0, 20).map((one, index) => (
                <li key={index}>
                  {one.what} <span class="dim">{one.at}</span>
                </li>
              ))}
            </ul>
          </dd>
          <dd />
        </>
      )}
    </dl>
  );
}

/** What is known of the body, which is worked out when it is looked at. */
function CalibrationRow({ id, said }: { id: string; said: object }) {
  const found = useAsync((signal) => get("/documents/{id}/calibration", { path: { id }, signal }), [id], [said]);
  const known = found.value;
  if (found.error) return null;
  // The row is there from the first, so that the buttons above it do not move once the answer comes.
  return (
    <>
      <dt>{w("label.receiptBody")}</dt>
      <dd class="calibrated">
        {(Object.keys(FACTS) as Fact[]).map((name) => (
          <span key={name} title={known?.[name].reason}>
            {w(FACTS[name])}{" "}
            {known ? (
              <>
                <span class={/guessed|unknown/.test(known[name].origin) ? "guess" : ""}>{shownValue(known[name])}</span>{" "}
                <span class="dim">{w(ORIGINS[known[name].origin])}</span>
              </>
            ) : (
              <span class="dim">…</span>
            )}
          </span>
        ))}
      </dd>
      <dd />
    </>
  );
}

/** How joints got their names, or which landmarks markers stand on. */
function NamingRow({ naming, joints }: { naming: Naming; joints: number }) {
  const landmarks = Object.entries(naming.landmarks);
  const listed = naming.joints.length + landmarks.length + naming.unmapped.length;
  return (
    <>
      <dt>{w(naming.rig === MARKERS ? "label.receiptMarkers" : "label.receiptJoints")}</dt>
      <dd>
        {naming.rig === MARKERS
          ? w("label.markersKnown", { known: landmarks.length, n: joints })
          : w("label.jointsMapped", {
              mapped: Object.keys(naming.mapped).length,
              n: joints,
              rig: naming.rig,
              own: naming.unmapped.length,
            })}
        {listed > 0 && (
          <details>
            <summary>{w("label.show")}</summary>
            <ul>
              {naming.joints.map((one) => (
                <li key={one.source}>
                  <code>{one.source}</code> {one.name}{" "}
                  <span class={one.confidence < DOUBTFUL ? "guess" : "dim"}>{number(one.confidence, 2)}</span>
                </li>
              ))}
              {landmarks.map(([marker, landmark]) => (
                <li key={marker}>
                  <code>{marker}</code> {landmark}
                </li>
              ))}
              {naming.unmapped.map((one) => (
                <li key={one.source}>
                  <code>{one.source}</code> <span class="dim">{one.why}</span>
                </li>
              ))}
            </ul>
          </details>
        )}
      </dd>
      <dd />
    </>
  );
}
