/** A query without XPath: conditions beside a body whose joints are picked, in step with the text of the editor both ways. */
import { useEffect, useState } from "preact/hooks";
import { Icon } from "../../../ui/icons";
import { w } from "../../../words";
import {
  expressionOf,
  jointsOf,
  NO_QUESTION,
  rowOf,
  withJoint,
  type Known,
  type Question,
  type Row,
  type RowKind,
} from "./question";
import { questionOf } from "./questionText";
import { useChoices, type Choice } from "./choices";
import { Figure } from "./Figure";
import { RowFields } from "./RowFields";
import { x } from "../words";

const SECONDS = 1;
const OF_JOINTS: ReadonlySet<RowKind> = new Set<RowKind>(["measure", "contact", "value"]);

/** The field that a pick on the body fills. */
interface Target {
  row: number;
  second: boolean;
}

export function Builder({
  project,
  text,
  document,
  onWrite,
  onRun,
}: {
  project: string;
  /** What stands in the editor. */
  text: string;
  /** A clip whose body is shown; null: none is known. */
  document: string | null;
  /** Write an expression, which is asked as soon as it stays for a moment. */
  onWrite: (expression: string) => void;
  onRun: () => void;
}) {
  const [kept, setKept] = useState<Question>(NO_QUESTION);
  const [target, setTarget] = useState<Target>({ row: 0, second: false });
  const choices = useChoices(project);
  const { names, joints } = choices;
  const known = { names: textsOf(names), joints: textsOf(joints) };
  const question = questionNow(text, kept);
  const change = (next: Question) => {
    setKept(next);
    onWrite(expressionOf(next));
  };
  const add = (row: Row, rows: readonly Row[] = question?.rows ?? []) => {
    setTarget({ row: rows.length, second: false });
    change({ all: question?.all ?? true, rows: [...rows, row] });
  };
  // A name that has come is chosen in the rows that wait for one, never in a text that is being typed.
  useEffect(() => {
    if (!question || text !== expressionOf(kept)) return;
    const rows = question.rows.map((row) => withName(row, known));
    if (rows.some((row, at) => row !== question.rows[at])) change({ ...question, rows });
  }, [names, joints]);
  if (!question) return <Beyond onAgain={() => onWrite(expressionOf(kept))} />;
  const { rows, all } = question;
  const set = (at: number, row: Row) => change({ all, rows: rows.map((one, index) => (index === at ? row : one)) });
  const aimed = rows[target.row];
  const pick = (joint: string) => {
    if (!aimed || !OF_JOINTS.has(aimed.kind)) add(rowOf("measure", known, joint));
    else set(target.row, withJoint(aimed, joint, target.second));
  };
  return (
    <form
      class="builder"
      aria-label={w("label.builder")}
      onSubmit={(event) => {
        event.preventDefault();
        onRun();
      }}
    >
      {document && <Figure document={document} joints={aimed ? jointsOf(aimed) : []} onPick={pick} />}
      <p class="dim builder-hint">
        {aimed && OF_JOINTS.has(aimed.kind) ? x("help.clickNext", { n: target.row + 1 }) : x("help.clickJoint")}
      </p>
      {rows.length > 1 && <Together all={all} onChange={(next) => change({ rows, all: next })} />}
      <div class="builder-rows">
        {rows.map((row, at) => (
          <div
            key={at}
            class={`builder-row${at === target.row && OF_JOINTS.has(row.kind) ? " aimed" : ""}`}
            role="group"
            aria-label={w("label.conditionOf", { n: at + 1 })}
          >
            <div class="row">
              {at > 0 ? (
                <Link row={row} all={all} place={at} onChange={(next) => set(at, next)} />
              ) : (
                <span class="dim">{w("label.framesWhere")}</span>
              )}
              <span class="grow" />
              <button
                type="button"
                class="button quiet icon dense"
                aria-label={w("button.removeCondition", { n: at + 1 })}
                onClick={() => change({ all, rows: withoutRow(rows, at) })}
              >
                <Icon name="close" />
              </button>
            </div>
            <div class="row wrap">
              <RowFields
                row={row}
                choices={choices}
                project={project}
                onChange={(next) => set(at, next)}
                onJoint={(second) => setTarget({ row: at, second })}
              />
            </div>
          </div>
        ))}
      </div>
      <AddButtons onAdd={(kind) => add(rowOf(kind, known))} />
      <button type="submit" class="unseen" tabIndex={-1}>
        {w("button.run")}
      </button>
    </form>
  );
}

const textsOf = (choices: readonly Choice[]): string[] => choices.map((one) => one.text);

/** The question that the text says: that of before with its unfinished rows, where it says the same; null: beyond rows. */
function questionNow(text: string, kept: Question): Question | null {
  if (text === expressionOf(kept)) return kept;
  return text.trim() ? questionOf(text, kept.all) : NO_QUESTION;
}

/** A row that waits for names, with a usual one. */
function withName(row: Row, known: Known): Row {
  const [name] = known.names;
  if (row.kind === "name") return row.name || !name ? row : { ...row, name };
  const usual = OF_JOINTS.has(row.kind) && !jointsOf(row)[0] ? jointsOf(rowOf(row.kind, known))[0] : "";
  return usual ? withJoint(row, usual) : row;
}

/** The first row has none before it. */
function withoutRow(rows: readonly Row[], at: number): Row[] {
  const others = rows.filter((_, index) => index !== at);
  return others.map((row, index) => (index ? row : { ...row, within: undefined }));
}

function Beyond({ onAgain }: { onAgain: () => void }) {
  return (
    <div class="builder folded">
      <p class="dim">{x("help.beyondBuilder")}</p>
      <button type="button" class="button dense" onClick={onAgain}>
        {w("button.builderAgain")}
      </button>
    </div>
  );
}

function Together({ all, onChange }: { all: boolean; onChange: (all: boolean) => void }) {
  return (
    <div class="segments" role="group" aria-label={w("label.framesWhere")}>
      <button type="button" aria-pressed={all} onClick={() => onChange(true)}>
        {w("label.everyRow")}
      </button>
      <button type="button" aria-pressed={!all} onClick={() => onChange(false)}>
        {w("label.anyRow")}
      </button>
    </div>
  );
}

/** How a row is joined with the one above: in the same frame, or in one soon after it. */
function Link({ row, all, place, onChange }: { row: Row; all: boolean; place: number; onChange: (row: Row) => void }) {
  const { within } = row;
  return (
    <>
      <select
        class="field"
        aria-label={x("label.linkOf", { n: place + 1 })}
        value={within === undefined ? "while" : "then"}
        onChange={(event) => onChange({ ...row, within: event.currentTarget.value === "then" ? SECONDS : undefined })}
      >
        <option value="while">{all ? x("label.while") : w("label.or")}</option>
        <option value="then">{x("label.thenWithin")}</option>
      </select>
      {within !== undefined && (
        <>
          <input
            class="field number"
            type="number"
            min="0.05"
            step="any"
            aria-label={x("label.withinSeconds", { n: place + 1 })}
            value={within}
            onInput={(event) => {
              const seconds = event.currentTarget.valueAsNumber;
              if (seconds > 0) onChange({ ...row, within: seconds });
            }}
          />
          <span class="dim">{x("label.seconds")}</span>
        </>
      )}
    </>
  );
}

const KINDS = [
  ["measure", () => x("label.measurement")],
  ["contact", () => x("label.contact")],
  ["activity", () => x("label.activity")],
  ["name", () => w("label.motionName")],
  ["value", () => w("label.jointValue")],
  ["frames", () => w("label.frameNumbersOf")],
] as const;

const AddButtons = ({ onAdd }: { onAdd: (kind: RowKind) => void }) => (
  <div class="row wrap">
    {KINDS.map(([kind, textOf]) => (
      <button key={kind} type="button" class="button dense" onClick={() => onAdd(kind)}>
        <Icon name="plus" />
        {textOf()}
      </button>
    ))}
  </div>
);
