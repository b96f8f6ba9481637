/** A question for those who do not know XPath: rows of choices, written into the editor as they change. */
import { useEffect, useState } from "preact/hooks";
import { get } from "../../api/client";
import { Icon } from "../../ui/icons";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import {
  CHANNELS,
  COMPARISONS,
  expressionOf,
  NO_QUESTION,
  rowOf,
  type Question,
  type Row,
  type RowKind,
} from "./builder";

const KINDS = { name: "motionName", value: "jointValue", frames: "frameNumbersOf" } as const;
const IS = { is: "is", not: "isNot", contains: "contains" } as const;

interface Choice {
  text: string;
  count: number | null;
}

export function Builder({
  project,
  text,
  onWrite,
  onRun,
}: {
  project: string;
  /** What stands in the editor. */
  text: string;
  onWrite: (expression: string) => void;
  onRun: () => void;
}) {
  const [question, setQuestion] = useState<Question>(NO_QUESTION);
  const written = expressionOf(question);
  const names = useChoices("//frame[motion_name='", project);
  const bones = useChoices("//frame_bone[@name='", project);
  const folded = text.trim() !== "" && text !== written;
  const change = (next: Question) => {
    setQuestion(next);
    onWrite(expressionOf(next));
  };
  const set = (at: number, row: Row) =>
    change({ ...question, rows: question.rows.map((one, index) => (index === at ? row : one)) });
  const add = (kind: RowKind) =>
    change({
      ...question,
      rows: [
        ...question.rows,
        rowOf(
          kind,
          names.map((one) => one.text),
          bones.map((one) => one.text),
        ),
      ],
    });
  // A name that has come is chosen in the rows that wait for one.
  useEffect(() => {
    const rows = question.rows.map((row) =>
      row.kind === "name" && !row.name && names[0]
        ? { ...row, name: names[0].text }
        : row.kind === "value" && !row.bone && bones[0]
          ? { ...row, bone: bones[0].text }
          : row,
    );
    if (!folded && rows.some((row, at) => row !== question.rows[at])) change({ ...question, rows });
  }, [names, bones]);
  if (folded) {
    return (
      <p class="builder folded row wrap dim">
        <Icon name="check" />
        {w("help.builderFolded")}
        <button type="button" class="button dense" onClick={() => onWrite(written)}>
          {w("button.builderAgain")}
        </button>
      </p>
    );
  }
  return (
    <form
      class="builder"
      aria-label={w("label.builder")}
      onSubmit={(event) => {
        event.preventDefault();
        onRun();
      }}
    >
      <div class="row wrap">
        <span>{w("label.framesWhere")}</span>
        {question.rows.length > 1 && (
          <div class="segments" role="group" aria-label={w("label.framesWhere")}>
            <button type="button" aria-pressed={question.all} onClick={() => change({ ...question, all: true })}>
              {w("label.everyRow")}
            </button>
            <button type="button" aria-pressed={!question.all} onClick={() => change({ ...question, all: false })}>
              {w("label.anyRow")}
            </button>
          </div>
        )}
      </div>
      <ul>
        {question.rows.map((row, at) => (
          <li key={at} class="row wrap" role="group" aria-label={w("label.conditionOf", { n: at + 1 })}>
            <span class="joined dim">{at ? w(question.all ? "label.and" : "label.or") : ""}</span>
            <RowFields row={row} names={names} bones={bones} onChange={(next) => set(at, next)} />
            <button
              type="button"
              class="button quiet icon dense"
              aria-label={w("button.removeCondition", { n: at + 1 })}
              onClick={() => change({ ...question, rows: question.rows.filter((_, index) => index !== at) })}
            >
              <Icon name="close" />
            </button>
          </li>
        ))}
      </ul>
      <div class="row wrap">
        {(["name", "value", "frames"] as const).map((kind) => (
          <button key={kind} type="button" class="button dense" onClick={() => add(kind)}>
            <Icon name="plus" />
            {w(`label.${KINDS[kind]}`)}
          </button>
        ))}
        <button type="submit" class="unseen" tabIndex={-1}>
          {w("button.run")}
        </button>
      </div>
    </form>
  );
}

function RowFields({
  row,
  names,
  bones,
  onChange,
}: {
  row: Row;
  names: Choice[];
  bones: Choice[];
  onChange: (row: Row) => void;
}) {
  const amount = (label: string, value: number, set: (value: number) => void) => (
    <input
      class="field number"
      type="number"
      step="any"
      aria-label={label}
      value={Number.isFinite(value) ? value : ""}
      onInput={(event) => set(event.currentTarget.valueAsNumber)}
    />
  );
  if (row.kind === "frames") {
    return (
      <>
        <span>{w("label.frameNumbersOf")}</span>
        {amount(w("label.trimFrom"), row.first, (first) => onChange({ ...row, first }))}
        <span class="dim">–</span>
        {amount(w("label.trimTo"), row.last, (last) => onChange({ ...row, last }))}
      </>
    );
  }
  if (row.kind === "name") {
    return (
      <>
        <span>{w("label.motionName")}</span>
        <select
          class="field"
          aria-label={w("label.comparison")}
          value={row.is}
          onChange={(event) => onChange({ ...row, is: event.currentTarget.value as typeof row.is })}
        >
          {(["is", "not", "contains"] as const).map((one) => (
            <option key={one} value={one}>
              {w(`label.${IS[one]}`)}
            </option>
          ))}
        </select>
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
            choices={names}
            onChange={(name) => onChange({ ...row, name })}
          />
        )}
      </>
    );
  }
  return (
    <>
      <Select
        label={w("label.bone")}
        value={row.bone}
        choices={bones}
        onChange={(bone) => onChange({ ...row, bone })}
      />
      <select
        class="field"
        aria-label={w("label.channel")}
        value={row.channel}
        onChange={(event) => onChange({ ...row, channel: event.currentTarget.value as typeof row.channel })}
      >
        {CHANNELS.map((one) => (
          <option key={one}>{one}</option>
        ))}
      </select>
      <select
        class="field"
        aria-label={w("label.comparison")}
        value={row.than}
        onChange={(event) => onChange({ ...row, than: event.currentTarget.value as typeof row.than })}
      >
        {COMPARISONS.map((one) => (
          <option key={one}>{one}</option>
        ))}
      </select>
      {amount(w("label.value"), row.value, (value) => onChange({ ...row, value }))}
    </>
  );
}

function Select({
  label,
  value,
  choices,
  onChange,
}: {
  label: string;
  value: string;
  choices: Choice[];
  onChange: (value: string) => void;
}) {
  const all = choices.some((one) => one.text === value) ? choices : [{ text: value, count: null }, ...choices];
  return (
    <select
      class="field builder-name"
      aria-label={label}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
    >
      {all.map((one) => (
        <option key={one.text} value={one.text}>
          {one.count === null ? one.text || "–" : `${one.text} (${w("label.clips", { n: one.count })})`}
        </option>
      ))}
    </select>
  );
}

/** Names that may stand in a place, with how many clips have each. */
function useChoices(before: string, project: string): Choice[] {
  const found = useAsync(
    (signal) => get("/xpath/complete", { query: { q: before, project: project || undefined }, signal }),
    [before, project],
  );
  return (found.value?.items ?? [])
    .filter((one) => one.kind.endsWith("name"))
    .map((one) => ({ text: one.text, count: one.documents ?? null }))
    .sort((a, b) => (b.count ?? 0) - (a.count ?? 0) || (a.text < b.text ? -1 : 1));
}
