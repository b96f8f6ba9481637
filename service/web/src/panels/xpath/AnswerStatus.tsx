/** What was found and how fast; copies, exports, a new clip of all frame ranges. */
import { useState } from "preact/hooks";
import { address, ask, type Schemas } from "../../api/client";
import { needsToken } from "../../state/session/me";
import { copyText, note, refuse } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { ArraysDialog } from "../../ui/exporting/ArraysDialog";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { w } from "../../words";
import type { Answered, Run } from "./answered";
import { Explain } from "./Explain";
import { x } from "./words";
import { asCommand, asCurl, asPython } from "./scripts";

const PIECES = 40; // that an address to the composer holds

/** A question as a name: its words. */
const slug = (q: string, between = "-"): string =>
  q
    .replace(/[^\p{L}\p{N}]+/gu, " ")
    .trim()
    .slice(0, 60)
    .trim()
    .replaceAll(" ", between) || w("label.untitled");

/** runs: those of the answer; none where it is of another kind. */
export function AnswerStatus({ answer, runs }: { answer: Answered; runs: Run[] }) {
  const [saving, setSaving] = useState(false);
  const { q, project } = answer;
  const totals = answer.totals ?? { frames: runs.reduce((sum, one) => sum + one.frames, 0), runs: runs.length };
  /** All runs, one after the other, as a new clip. */
  const saveAsClip = async () => {
    setSaving(true);
    try {
      const name = slug(q, " ");
      const made = await ask("post", "/compose", {
        body: { segments: [{ xpath: q, project: project || null, first: 1 }], name } as Schemas["ComposeRequest"],
      });
      note(w("label.composed", { name }), {
        action: { text: w("button.open"), run: () => go(`/clips/${made.document}`) },
      });
    } catch (problem) {
      refuse(problem);
    } finally {
      setSaving(false);
    }
  };
  return (
    <div class="xpath-status row wrap" role="status">
      <span>
        {answer.as === "runs"
          ? w("label.resultRuns", {
              frames: w("label.frames", { n: totals.frames }),
              runs: w("label.runCount", { n: totals.runs }),
              ms: answer.ms,
            })
          : w(answer.type === "nodes" ? "label.resultNodes" : "label.resultValues", {
              n: answer.total ?? answer.items.length,
              ms: answer.ms,
            })}
      </span>
      {answer.per && (
        <span class="dim" title={w("help.perDocumentHelp")}>
          {w("label.perDocumentAsked")}
        </span>
      )}
      {answer.cursor && <span class="dim">{w("help.firstShown", { n: answer.items.length })}</span>}
      {!answer.complete && (
        <span class="cut-off">
          <Icon name="warn" />
          {w("help.cutOff")}
        </span>
      )}
      <Notes texts={answer.warnings.map(withoutOption)} />
      <span class="grow" />
      <Explain explain={answer.explain} />
      <Copies answer={answer} />
      <Exports answer={answer} hasRuns={runs.length > 0} />
      {runs.length > 0 && !answer.per && (
        <button
          type="button"
          class="button dense"
          disabled={saving || !answer.guesses}
          title={answer.guesses ? undefined : x("help.saveWithGuesses")}
          onClick={() => void saveAsClip()}
        >
          {w("button.saveAsClip")}
        </button>
      )}
      {runs.length > 0 && (
        <button type="button" class="button dense" onClick={() => go(`/compose?s=${piecesOf(runs)}`)}>
          {runs.length > PIECES ? w("button.toComposerFirst", { n: PIECES }) : w("button.toComposer")}
        </button>
      )}
    </div>
  );
}

/** Of the page's own switch, a note does not say how requests set it. */
const withoutOption = (text: string): string => text.replace("; guesses=no leaves them out", "");

/** What the answer leaves out or rests on: one sentence is shown, several open. */
function Notes({ texts }: { texts: string[] }) {
  if (texts.length < 2) return <span class="dim">{texts[0]}</span>;
  return (
    <details class="answer-notes dim">
      <summary>{x("label.notes", { n: texts.length })}</summary>
      <ul>
        {texts.map((one) => (
          <li key={one}>{one}</li>
        ))}
      </ul>
    </details>
  );
}

/** The answer as a file: its nodes, or the numbers of its frames. */
function Exports({ answer, hasRuns }: { answer: Answered; hasRuns: boolean }) {
  const [numbers, setNumbers] = useState(false);
  const { q, project, per, guesses } = answer;
  const left = guesses ? {} : ({ guesses: "no" } as const);
  return (
    <>
      <Menu
        label={w("button.exportAll")}
        className="button quiet dense"
        side="right"
        items={[
          ...(["xml", "ndjson", "csv"] as const).map((one) => ({
            text: one.toUpperCase(),
            href: address("/xpath", {}, { q, project, as: one, per: per ? "document" : undefined, ...left }),
            download: `${slug(q)}.${one}`,
          })),
          ...(hasRuns && !per ? [{ text: w("label.arraysFile"), run: () => setNumbers(true) }] : []),
        ]}
      >
        {w("button.exportAll")}
        <Icon name="down" />
      </Menu>
      {numbers && (
        <ArraysDialog
          source={{ query: q, ...left, ...(project ? { selection: { project } } : {}) }}
          about={w("help.arraysOfQuery")}
          onClose={() => setNumbers(false)}
        />
      )}
    </>
  );
}

/** Frame ranges as the composer's address has them. */
const piecesOf = (runs: Run[]): string =>
  runs
    .slice(0, PIECES)
    .map((one) => `${one.document}:${one.first}-${one.last}`)
    .join(",");

/** The query as a line for a shell or for Python. */
function Copies({ answer }: { answer: Answered }) {
  const { q, project, per, guesses } = answer;
  const values = answer.as === "json" && answer.type !== "nodes";
  const question = { q, project, per, guesses, form: answer.as, values, token: needsToken() };
  const copied = question.token ? w("help.copiedToken") : w("label.copied");
  const copies = [
    { text: w("label.asCurl"), run: () => void copyText(asCurl(question, location.origin), copied) },
    { text: w("label.asCommand"), run: () => void copyText(asCommand(question, location.origin), copied) },
    { text: w("label.asPython"), run: () => void copyText(asPython(question, location.origin), copied) },
  ];
  return (
    <Menu label={w("button.copy")} className="button quiet dense" side="right" items={copies}>
      {w("button.copy")}
      <Icon name="down" />
    </Menu>
  );
}
