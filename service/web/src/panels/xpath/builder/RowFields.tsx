/** The fields of one condition. */
import { w } from "../../../words";
import { activityText, ACTIVITIES, angleText, jointText } from "../../../ui/bodies/bodyNames";
import {
  CHANNELS,
  COMPARISONS,
  jointOfAngle,
  measureOf,
  QUANTITIES,
  type MeasureRow,
  type QuantityName,
  type Row,
} from "./question";
import type { Choices } from "./choices";
import { Select, Words } from "./Select";
import { Threshold } from "./Threshold";
import { x } from "../words";

interface Fields<R> {
  row: R;
  choices: Choices;
  project: string;
  onChange: (row: R) => void;
  /** A field of a joint has the focus. second: of the other joint. */
  onJoint: (second: boolean) => void;
}

export function RowFields({ row, choices, project, onChange, onJoint }: Fields<Row>) {
  switch (row.kind) {
    case "measure":
      return (
        <MeasureFields
          row={row}
          choices={choices}
          project={project}
          onJoint={onJoint}
          onChange={(next) => onChange({ ...row, ...next })}
        />
      );
    case "contact":
      return (
        <>
          <Joint {...{ choices, onJoint }} joint={row.joint} onChange={(joint) => onChange({ ...row, joint })} />
          <Words
            label={w("label.comparison")}
            value={row.is ? "yes" : "no"}
            words={{ yes: x("label.isOnGround"), no: x("label.isOffGround") }}
            onChange={(value) => onChange({ ...row, is: value === "yes" })}
          />
        </>
      );
    case "activity":
      return (
        <>
          <span>{x("label.activity")}</span>
          <Words
            label={w("label.comparison")}
            value={row.is ? "yes" : "no"}
            words={{ yes: x("label.doing"), no: x("label.notDoing") }}
            onChange={(value) => onChange({ ...row, is: value === "yes" })}
          />
          <Select
            label={x("label.activity")}
            value={row.name}
            choices={ACTIVITIES.map((text) => ({ text, count: null }))}
            textOf={activityText}
            onChange={(name) => onChange({ ...row, name })}
          />
        </>
      );
    case "frames":
      return (
        <>
          <span>{w("label.frameNumbersOf")}</span>
          <Amount label={w("label.trimFrom")} value={row.first} onChange={(first) => onChange({ ...row, first })} />
          <span class="dim">–</span>
          <Amount label={w("label.trimTo")} value={row.last} onChange={(last) => onChange({ ...row, last })} />
        </>
      );
    case "name":
      return (
        <>
          <span>{w("label.motionName")}</span>
          <Words
            label={w("label.comparison")}
            value={row.is}
            words={{ is: w("label.is"), not: w("label.isNot"), contains: w("label.contains") }}
            onChange={(is) => onChange({ ...row, is })}
          />
          {row.is === "contains" ? (
            <input
              class="field"
              aria-label={w("label.motionName")}
              value={row.name}
              onInput={(event) => onChange({ ...row, name: event.currentTarget.value })}
            />
          ) : (
            <Select
              label={w("label.motionName")}
              value={row.name}
              choices={choices.names}
              onChange={(name) => onChange({ ...row, name })}
            />
          )}
        </>
      );
    case "value":
      return (
        <>
          <Select
            label={w("label.bone")}
            value={row.bone}
            choices={choices.joints}
            onFocus={() => onJoint(false)}
            onChange={(bone) => onChange({ ...row, bone })}
          />
          <Words
            label={w("label.channel")}
            value={row.channel}
            words={sameWords(CHANNELS)}
            onChange={(channel) => onChange({ ...row, channel })}
          />
          <Words
            label={w("label.comparison")}
            value={row.than}
            words={sameWords(COMPARISONS)}
            onChange={(than) => onChange({ ...row, than })}
          />
          <Amount label={w("label.value")} value={row.value} onChange={(value) => onChange({ ...row, value })} />
        </>
      );
  }
}

const sameWords = <T extends string>(words: readonly T[]): Record<T, T> =>
  Object.fromEntries(words.map((one) => [one, one])) as Record<T, T>;

function Joint({
  joint,
  choices,
  second = false,
  onJoint,
  onChange,
}: {
  joint: string;
  choices: Choices;
  second?: boolean;
  onJoint: (second: boolean) => void;
  onChange: (joint: string) => void;
}) {
  return (
    <Select
      label={x(second ? "label.otherJoint" : "label.jointWord")}
      value={joint}
      choices={choices.joints}
      textOf={jointText}
      onFocus={() => onJoint(second)}
      onChange={onChange}
    />
  );
}

function MeasureFields({ row, choices, project, onChange, onJoint }: Fields<MeasureRow>) {
  const joints = choices.joints.map((one) => one.text);
  const { quantity } = row;
  const near = quantity === "distance";
  return (
    <>
      {quantity === "angle" ? (
        <Select
          label={w("label.quantityAngle")}
          value={row.joint}
          choices={choices.angles}
          textOf={angleText}
          onFocus={() => onJoint(false)}
          onChange={(joint) => onChange({ ...row, joint })}
        />
      ) : (
        <Joint {...{ choices, onJoint }} joint={row.joint} onChange={(joint) => onChange({ ...row, joint })} />
      )}
      <Words
        label={x("label.measurement")}
        value={quantity}
        words={Object.fromEntries(QUANTITIES.map((one) => [one, x(`label.q_${one}`)])) as Record<QuantityName, string>}
        onChange={(next) => onChange(measureOf(next, jointOf(row, joints), joints))}
      />
      {row.other !== "" && (
        <Joint {...{ choices, onJoint }} second joint={row.other} onChange={(other) => onChange({ ...row, other })} />
      )}
      <Words
        label={w("label.comparison")}
        value={row.than}
        words={{
          ">": x(near ? "label.fartherThan" : "label.above"),
          "<": x(near ? "label.nearerThan" : "label.below"),
        }}
        onChange={(than) => onChange({ ...row, than })}
      />
      {quantity !== "above" && (
        <Threshold row={row} project={project} onChange={(value) => onChange({ ...row, value })} />
      )}
    </>
  );
}

/** The joint that a row is about, for another measurement of it. */
const jointOf = (row: MeasureRow, joints: readonly string[]): string =>
  row.quantity === "angle" ? jointOfAngle(row.joint) || (joints[0] ?? "") : row.joint;

function Amount({ label, value, onChange }: { label: string; value: number; onChange: (value: number) => void }) {
  return (
    <input
      class="field number"
      type="number"
      step="any"
      aria-label={label}
      value={Number.isFinite(value) ? value : ""}
      onInput={(event) => onChange(event.currentTarget.valueAsNumber)}
    />
  );
}
