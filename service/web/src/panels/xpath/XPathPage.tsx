/** Ask the library: editor, answer as a table, its runs playing one after the other. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { closeCompletion } from "@codemirror/autocomplete";
import type { EditorView } from "@codemirror/view";
import { get } from "../../api/client";
import { offer } from "../../state/session/keys";
import { askMe } from "../../state/session/me";
import { param } from "../../state/session/route";
import { subject } from "../../state/session/shell";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import type { Run } from "./answered";
import { AnswerStatus } from "./AnswerStatus";
import { AnswerTable } from "./AnswerTable";
import { AskBar, building } from "./AskBar";
import { Builder } from "./builder/Builder";
import { mountXPath } from "./editor";
import { Examples } from "./Examples";
import { useAnswer } from "./useAnswer";
import "../../styles/xpath.css";

const LIVE_DELAY = 200; // ms

export function XPathPage() {
  const host = useRef<HTMLDivElement>(null);
  const editor = useRef<EditorView | null>(null);
  const soon = useRef(0);
  const [text, setText] = useState(param("q"));
  const empty = useIsEmpty();
  const asking = useAnswer();
  const { answer, error, busy } = asking;
  const run = (query = editor.current?.state.doc.toString() ?? text) => {
    // The list of completions would cover the answer.
    if (editor.current) closeCompletion(editor.current);
    return asking.run(query);
  };
  const runNow = useRef(run);
  runNow.current = run;

  useEffect(() => {
    subject.value = null;
    void askMe();
    editor.current = mountXPath(host.current!, param("q"), setText, () => void runNow.current());
    if (param("q")) void runNow.current(param("q"));
    else editor.current.focus();
    const keys = offer("xpath", [
      { id: "run", word: "button.run", keys: ["Ctrl+Enter"], run: () => void runNow.current() },
    ]);
    return () => {
      keys();
      window.clearTimeout(soon.current);
      asking.stop();
      editor.current?.destroy();
    };
  }, []);
  const put = (query: string) =>
    editor.current?.dispatch({ changes: { from: 0, to: editor.current.state.doc.length, insert: query } });
  const write = (query: string) => {
    put(query);
    void run(query);
  };
  /** What the builder says is asked once it stays for a moment. */
  const build = (query: string) => {
    put(query);
    window.clearTimeout(soon.current);
    soon.current = window.setTimeout(() => void asking.runLive(query), LIVE_DELAY);
  };
  const project = param("project");
  const examples = useAsync(
    (signal) => get("/xpath/examples", { query: { project: project || undefined }, signal }),
    [project],
  );
  const runs = useMemo(() => (answer?.as === "runs" ? (answer.items as Run[]) : []), [answer]);
  return (
    <div class={`xpath${building.value ? " with-builder" : ""}`}>
      <h1 class="unseen">{w("label.xpath")}</h1>
      <AskBar text={text} onAsk={() => void run()} onChoose={write} />
      <div class="xpath-body">
        {building.value && !empty && (
          <Builder
            project={project}
            text={text}
            document={examples.value?.document ?? null}
            onWrite={build}
            onRun={() => void run()}
          />
        )}
        <div class="xpath-main">
          <div class="xpath-editor">
            <div ref={host} class="xpath-host" />
            <button
              type="button"
              class="button primary"
              disabled={!text.trim()}
              onClick={() => void run()}
              title="Ctrl+Enter"
            >
              {w("button.run")}
            </button>
          </div>
          {busy && <div class="busy" />}
          <Trouble error={error} />
          {answer && <AnswerStatus answer={answer} runs={runs} />}
          {!answer && !error && !busy && <Start empty={empty} examples={examples} onChoose={write} />}
          {answer && (
            <AnswerTable
              answer={answer}
              runs={runs}
              isOld={asking.isOld}
              onEnd={() => {
                if (!busy) void asking.more();
              }}
            />
          )}
        </div>
      </div>
    </div>
  );
}

/** Before the first question. empty: whether there are no clips; null until that is known. */
function Start({
  empty,
  examples,
  onChoose,
}: {
  empty: boolean | null;
  examples: Parameters<typeof Examples>[0]["found"];
  onChoose: (query: string) => void;
}) {
  if (empty)
    return (
      <EmptyState
        picture="xpath"
        makes={w("help.xpathStart")}
        parts={["people"]}
        onDemo={() => onChoose("//frame[motion_name = 'wave']")}
      />
    );
  return empty === false ? <Examples found={examples} onChoose={onChoose} /> : null;
}
