/** Why a measure of the body has no value, with the button that mends it. */
import { get } from "../../../api/client";
import { causeOf, type Ground, type Kind } from "../../../motion/body/quantities";
import type { Clip } from "../../../state/clip/clip";
import { mayEdit } from "../../../state/session/me";
import { setParams } from "../../../state/session/route";
import { confirmFact } from "../../../state/importing/uploads";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w, type Word } from "../../../words";

// px from the threshold that take hold of it
const CAUSES: Record<Ground | "joints", Word> = {
  rate: "label.rateLacks",
  unit: "label.unitLacks",
  up: "label.upLacks",
  floor: "label.floorLacks",
  leg: "error.jointsLack",
  joints: "error.jointsLack",
};

/** Why a measurement of the file has no value. */
export const NoMeasurement = ({ reason }: { reason: string }) => (
  <div class="empty" role="status">
    <p>
      <strong>{w("error.noMeasurement")}</strong>
    </p>
    {reason && <p class="dim">{reason}</p>}
  </div>
);

/** Why a quantity has no value, and the button that mends it. */
export function Unknown({ clip, kind, reload }: { clip: Clip; kind: Kind; reload: () => void }) {
  const found = useAsync(
    (signal) =>
      get("/documents/{id}/calibration", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }),
    [clip],
  );
  const facts = found.value;
  if (!facts) return <Trouble error={found.error} retry={found.again} />;
  const cause = causeOf(kind, (ground) =>
    ground === "rate" ? Boolean(clip.detail.seconds_per_frame) : facts[ground].origin !== "unknown",
  );
  const likely = clip.skeleton.view.likely_unit;
  const mends = clip.pinned === null && mayEdit();
  const toFloor = () => {
    const part = document.querySelector<HTMLDetailsElement>("details.calibration");
    if (part) part.open = true;
    part?.querySelector<HTMLInputElement>(`[aria-label="${w("label.floor")}"]`)?.focus();
  };
  const button = (text: string, run: () => void) =>
    mends && (
      <button type="button" class="button primary" onClick={run}>
        {text}
      </button>
    );
  return (
    <div class="empty" role="status">
      <p>
        <strong>{w(CAUSES[cause ?? "joints"])}</strong>
      </p>
      {cause && cause !== "rate" && facts[cause].reason && <p class="dim">{facts[cause].reason}</p>}
      <p>
        {cause === "floor"
          ? button(w("button.setFloor"), toFloor)
          : cause === "unit" && likely && !likely.includes("/")
            ? button(
                w("button.confirmAs", { value: likely }),
                () => void confirmFact([clip.id], { unit: likely }).then((done) => done && reload()),
              )
            : cause
              ? button(
                  w(cause === "rate" ? "button.giveRate" : cause === "unit" ? "button.giveUnit" : "button.giveUp"),
                  () => setParams({ tab: "info" }),
                )
              : null}
      </p>
    </div>
  );
}
