/** Chooses a measurement of the body, or of the file, such as a force plate and an axis. */
import { get } from "../../api/client";
import {
  ANGLE,
  argumentOf,
  FEET,
  FILE_KINDS,
  isOfFile,
  JOINT_KINDS,
  KINDS,
  measuredArgument,
  nameAndAxis,
  PLACE_AXES,
  type Asked,
  type Kind,
  type Measured,
} from "../../motion/body/quantities";
import { useAsync } from "../useAsync";
import { w, type Word } from "../../words";

export const AXIS_WORDS: Partial<Record<string, Word>> = {
  up: "label.axisUp",
  front: "label.front",
  left: "label.sideLeft",
};

export const KIND_WORDS: Record<Kind, Word> = {
  height: "label.quantityHeight",
  position: "label.quantityPosition",
  speed: "label.quantitySpeed",
  acceleration: "label.quantityAcceleration",
  angle: "label.quantityAngle",
  contact: "label.quantityContact",
  heading: "label.quantityHeading",
  quantity: "label.quantityModel",
  force: "label.quantityForce",
  cop: "label.quantityPressure",
  "free-moment": "label.quantityMoment",
  analog: "label.quantityAnalog",
};

export function MeasurementChoice({
  asked,
  bones,
  measured,
  choose,
}: {
  asked: Asked;
  bones: readonly string[];
  measured: readonly Measured[];
  choose: (next: Asked) => void;
}) {
  const angles = useAsync((signal) => get("/xpath/complete", { query: { q: ANGLE }, signal }), []);
  const items = (angles.value?.items ?? []).filter((each) => each.kind === "angle");
  const named = items.map((each) => each.text);
  const old = new Set(items.filter((each) => each.detail.startsWith("goniometer")).map((each) => each.text));
  const kinds = [
    ...KINDS,
    ...FILE_KINDS.filter((kind) => asked.kind === kind || measured.some((each) => each.function === kind)),
  ];
  const chooseKind = (kind: Kind) => {
    const first = measured.find((each) => each.function === kind);
    const argument = first ? measuredArgument(first, nameAndAxis(asked)[1]) : argumentOf(kind, asked, bones);
    choose({ kind, argument });
  };
  return (
    <>
      <select
        class="field"
        aria-label={w("label.quantity")}
        value={asked.kind}
        onChange={(event) => chooseKind(event.currentTarget.value as Kind)}
      >
        {kinds.map((kind) => (
          <option key={kind} value={kind}>
            {w(KIND_WORDS[kind])}
          </option>
        ))}
      </select>
      {(JOINT_KINDS.has(asked.kind) || asked.kind === "angle") && (
        <select
          class="field"
          aria-label={w(asked.kind === "angle" ? "label.quantityAngle" : "label.joints")}
          value={asked.argument}
          onChange={(event) => choose({ ...asked, argument: event.currentTarget.value })}
        >
          {asked.kind === "contact" &&
            FEET.map((side) => (
              <option key={side} value={side}>
                {w(side === "left" ? "label.leftFootSteps" : "label.rightFootSteps")}
              </option>
            ))}
          {(asked.kind === "angle" ? [...new Set([asked.argument, ...named])] : bones).map((name) => (
            <option key={name} value={name}>
              {asked.kind === "angle" && old.has(name) ? w("label.goniometerAngle", { name }) : name}
            </option>
          ))}
        </select>
      )}
      {asked.kind === "position" && <Place asked={asked} bones={bones} choose={choose} />}
      {isOfFile(asked.kind) && (
        <FileMeasurement
          asked={asked}
          measured={measured}
          choose={(argument) => choose({ kind: asked.kind, argument })}
        />
      )}
    </>
  );
}

const axisName = (axis: string): string => {
  const word = AXIS_WORDS[axis];
  return word ? w(word) : axis.toUpperCase();
};

/** A joint, and the axis along which it is. */
function Place({ asked, bones, choose }: { asked: Asked; bones: readonly string[]; choose: (next: Asked) => void }) {
  const [joint, axis] = nameAndAxis(asked);
  const take = (next: string, along: string) => choose({ kind: "position", argument: `${next},${along}` });
  return (
    <>
      <select
        class="field"
        aria-label={w("label.joints")}
        value={joint}
        onChange={(event) => take(event.currentTarget.value, axis)}
      >
        {bones.map((name) => (
          <option key={name} value={name}>
            {name}
          </option>
        ))}
      </select>
      <select
        class="field"
        aria-label={w("label.axis")}
        value={axis}
        onChange={(event) => take(joint, event.currentTarget.value)}
      >
        {PLACE_AXES.map((each) => (
          <option key={each} value={each}>
            {axisName(each)}
          </option>
        ))}
      </select>
    </>
  );
}

const plateOrFoot = (name: string): string => {
  if (name === "left") return w("label.sideLeft");
  return name === "right" ? w("label.sideRight") : w("label.plate", { number: name });
};

function FileMeasurement({
  asked,
  measured,
  choose,
}: {
  asked: Asked;
  measured: readonly Measured[];
  choose: (argument: string) => void;
}) {
  const [name, axis] = nameAndAxis(asked);
  const own = measured.filter((each) => each.function === asked.kind);
  const chosen = own.find((each) => each.name === name);
  const pick = (to: string) => {
    const next = own.find((each) => each.name === to);
    if (next) choose(measuredArgument(next, axis));
  };
  return (
    <>
      <select
        class="field"
        aria-label={w("label.measurementName")}
        value={name}
        onChange={(event) => pick(event.currentTarget.value)}
      >
        {[...new Set([name, ...own.map((each) => each.name)])].map((each) => (
          <option key={each} value={each}>
            {asked.kind === "quantity" || asked.kind === "analog" ? each : plateOrFoot(each)}
          </option>
        ))}
      </select>
      {chosen && chosen.axes.length > 0 && (
        <select
          class="field"
          aria-label={w("label.axis")}
          value={axis}
          onChange={(event) => choose(measuredArgument(chosen, event.currentTarget.value))}
        >
          {chosen.axes.map((each) => (
            <option key={each} value={each}>
              {each.toUpperCase()}
            </option>
          ))}
        </select>
      )}
    </>
  );
}
