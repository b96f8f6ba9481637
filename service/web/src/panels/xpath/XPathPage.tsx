/** Ask the library: editor, answer as a table, its runs playing one after the other. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { EditorView } from "@codemirror/view";
import { ApiError, address, ask, get, type Schemas } from "../../api/client";
import { copyText } from "../../shell/App";
import { subject } from "../../shell/Bar";
import { offer } from "../../state/keys";
import { note, refuse } from "../../state/notes";
import { asked, remember } from "../../state/queries";
import { go, param, setParams } from "../../state/route";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { VirtualList } from "../../ui/VirtualList";
import { number, w } from "../../words";
import { mountXPath } from "./editor";
import { RunPlayer } from "./RunPlayer";
import { SavedQueries } from "./SavedQueries";
import "../../styles/xpath.css";

type Run = Schemas["RunItem"];
type Node = Schemas["NodeItem"];
interface Answered { as: "runs" | "json"; items: (Run | Node | { value?: unknown; document?: string })[]; cursor: string | null; ms: number; explain: unknown; complete: boolean; warnings: string[] }

const EXAMPLES = ["//frame[motion_name='left-arm-abduction']", "//frame_bone[@name='left_up_arm'][@Rx > 45]/..", "distinct-values(//motion_name)", "count(//frame)", "//frame[position() <= 30]"];

export function XPathPage() {
  const host = useRef<HTMLDivElement>(null);
  const editor = useRef<EditorView | null>(null);
  const [text, setText] = useState(param("q"));
  const [answer, setAnswer] = useState<Answered | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const [picked, setPicked] = useState(0);
  const [saving, setSaving] = useState(false);
  const stop = useRef<AbortController | null>(null);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const as = param("as") === "nodes" ? "json" : "runs";
  const project = param("project");

  const run = async (query = editor.current?.state.doc.toString() ?? text, cursor: string | null = null, form = param("as") === "nodes" ? "json" as const : "runs" as const) => {
    if (!query.trim()) return;
    stop.current?.abort();
    stop.current = new AbortController();
    setBusy(true);
    setError(null);
    const began = performance.now();
    try {
      const found = (await get("/xpath", { query: { q: query, as: form, project: param("project") || undefined, limit: 500, cursor: cursor ?? undefined, explain: true }, signal: stop.current.signal })) as Schemas["QueryAnswer"];
      const ms = Math.round(performance.now() - began);
      const items: Answered["items"] = found.items ?? [{ value: found.value }];
      setAnswer((before) => ({ as: found.type === "runs" ? "runs" : "json", items: cursor && before ? [...before.items, ...items] : items, cursor: found.next_cursor ?? null, ms, explain: found.explain, complete: found.complete !== false, warnings: found.warnings ?? [] }));
      if (!cursor) { setPicked(0); remember(query); setParams({ q: query }); }
    } catch (problem) {
      if ((problem as Error).name === "AbortError") return;
      // An answer that is one value has no runs; it is asked as nodes without a word.
      if (form === "runs" && problem instanceof ApiError && /runs|frames/i.test(problem.message) && problem.status === 422) return void run(query, null, "json");
      setError(problem);
      setAnswer(null);
    } finally {
      setBusy(false);
    }
  };
  const runNow = useRef(run);
  runNow.current = run;

  useEffect(() => {
    subject.value = null;
    editor.current = mountXPath(host.current!, param("q"), setText, () => void runNow.current());
    if (param("q")) void runNow.current(param("q"));
    else editor.current.focus();
    const keys = offer("xpath", [{ id: "run", word: "run", keys: ["Ctrl+Enter"], run: () => void runNow.current() }]);
    return () => { keys(); stop.current?.abort(); editor.current?.destroy(); };
  }, []);
  /** All runs, one after the other, as a new clip. */
  const saveAsClip = async () => {
    setSaving(true);
    try {
      const name = text.replace(/[^\p{L}\p{N}]+/gu, " ").trim().slice(0, 60) || w("untitled");
      const made = await ask("post", "/compose", { body: { segments: [{ xpath: text, project: project || null, first: 1 }], name } as Schemas["ComposeRequest"] });
      note(w("composed", { name }), { action: { text: w("open"), run: () => go(`/clips/${made.document}`) } });
    } catch (problem) {
      refuse(problem);
    } finally {
      setSaving(false);
    }
  };
  const write = (query: string) => {
    editor.current?.dispatch({ changes: { from: 0, to: editor.current.state.doc.length, insert: query } });
    void run(query);
  };
  const runs = useMemo(() => (answer?.as === "runs" ? (answer.items as Run[]) : []), [answer]);
  const frames = runs.reduce((sum, one) => sum + one.frames, 0);
  const curl = `curl -G ${location.origin}/api/v1/xpath --data-urlencode "q=${text.replaceAll('"', '\\"')}" -d as=runs`;
  return (
    <div class="xpath">
      <h1 class="unseen">{w("xpath")}</h1>
      <div class="xpath-bar row wrap">
        <label class="row"><span class="dim">{w("scope")}</span>
          <select class="field" value={project} onChange={(event) => { setParams({ project: event.currentTarget.value || null }); void run(); }}>
            <option value="">{w("wholeLibrary")}</option>
            {(projects.value?.items ?? []).map((one) => <option key={one} value={one}>{one}</option>)}
          </select>
        </label>
        <div class="segments" role="group" aria-label={w("answerAs")}>
          <button type="button" aria-pressed={as === "runs"} onClick={() => { setParams({ as: null }); void run(undefined, null, "runs"); }}>{w("runs")}</button>
          <button type="button" aria-pressed={as === "json"} onClick={() => { setParams({ as: "nodes" }); void run(undefined, null, "json"); }}>{w("nodes")}</button>
        </div>
        <span class="grow" />
        <SavedQueries text={text} onChoose={write} />
        <Menu label={w("queryHistory")} className="button quiet" side="right" items={asked.value.slice(0, 20).map((one) => ({ text: one.length > 70 ? `${one.slice(0, 70)}…` : one, run: () => write(one) }))}><Icon name="down" /></Menu>
      </div>
      <div class="xpath-editor">
        <div ref={host} class="xpath-host" />
        <button type="button" class="button primary" disabled={!text.trim()} onClick={() => void run()} title="Ctrl+Enter">{w("run")}</button>
      </div>
      {busy && <div class="busy" />}
      <Trouble error={error} />
      {answer && (
        <div class="xpath-status row wrap" role="status">
          <span>{answer.as === "runs" ? w("resultRuns", { frames: w("frames", { n: frames }), runs: w("runCount", { n: runs.length }), ms: answer.ms }) : w("resultNodes", { n: answer.items.length, ms: answer.ms })}</span>
          {!answer.complete && <span class="chip">{w("incomplete")}</span>}
          {answer.warnings.map((one) => <span key={one} class="dim">{one}</span>)}
          <span class="grow" />
          <Explain explain={answer.explain} />
          <button type="button" class="button quiet dense" onClick={() => void copyText(curl, w("copied"))}>{w("asCurl")}</button>
          <button type="button" class="button quiet dense" onClick={() => void copyText(`mcml xpath ${JSON.stringify(text)} --as runs`, w("copied"))}>{w("asCommand")}</button>
          <Menu label={w("exportAll")} className="button quiet dense" side="right" items={(["xml", "ndjson", "csv"] as const).map((one) => ({ text: one.toUpperCase(), href: address("/xpath", {}, { q: text, project, as: one }), download: true }))}>{w("exportAll")}<Icon name="down" /></Menu>
          {runs.length > 0 && <button type="button" class="button dense" disabled={saving} onClick={() => void saveAsClip()}>{w("saveAsClip")}</button>}
          {runs.length > 0 && <button type="button" class="button dense" onClick={() => go(`/compose?s=${runs.slice(0, 40).map((one) => `${one.document}:${one.first}-${one.last}`).join(",")}`)}>{w("toComposer")}</button>}
        </div>
      )}
      {!answer && !error && !busy && (
        <div class="empty"><h2>{w("xpathStart")}</h2><p class="dim">{w("xpathExamples")}</p>
          <ul class="examples">{EXAMPLES.map((one) => <li key={one}><button type="button" class="button quiet code" onClick={() => write(one)}>{one}</button></li>)}</ul></div>
      )}
      {answer && (answer.items.length === 0 ? <div class="empty"><p>{w("noAnswer")}</p></div> : (
        <div class="xpath-answer">
          <div class="xpath-table">
            {answer.as === "runs" && <div class="run-row run-head" aria-hidden="true"><span class="n">#</span><span>{w("document")}</span><span class="n">{w("from")}</span><span class="n">{w("last")}</span><span class="n">{w("length")}</span></div>}
            <VirtualList rows={answer.items.length} height={28} label={w("complete")} role="listbox" at={picked}
              onSeen={(_, last) => { if (answer.cursor && last >= answer.items.length - 5 && !busy) void run(text, answer.cursor, answer.as); }}
              onKeyDown={(event) => {
                const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
                if (step) { setPicked(Math.max(0, Math.min(answer.items.length - 1, picked + step))); event.preventDefault(); }
                if (event.key === "Enter" && runs[picked]) go(`/clips/${runs[picked].document}?f=${runs[picked].first}&in=${runs[picked].first}&out=${runs[picked].last}`);
              }}
              render={(row) => {
                const item = answer.items[row];
                const props = { role: "option", "aria-selected": row === picked, tabIndex: row === picked ? 0 : -1, onClick: () => setPicked(row) } as const;
                if (answer.as === "runs") {
                  const one = item as Run;
                  return <div class="run-row" {...props} onDblClick={() => go(`/clips/${one.document}?f=${one.first}&in=${one.first}&out=${one.last}`)}><span class="n dim">{number(row + 1)}</span><span class="cut">{one.name}</span><span class="n">{number(one.first)}</span><span class="n">{number(one.last)}</span><span class="n dim">{w("frames", { n: one.frames })}</span></div>;
                }
                const node = item as Partial<Node> & { value?: unknown };
                return <div class="run-row node-row" {...props}><span class="n dim">{number(row + 1)}</span><code class="cut">{String(node.value ?? "")}</code><span class="cut dim" title={node.address}>{node.address ?? node.document ?? ""}</span></div>;
              }} />
          </div>
          {runs.length > 0 && <RunPlayer runs={runs} at={picked} onAt={setPicked} />}
        </div>
      ))}
    </div>
  );
}

function Explain({ explain }: { explain: unknown }) {
  if (!explain) return null;
  const rows = Object.entries(explain as Record<string, unknown>).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return (
    <details class="explain"><summary class="button quiet dense">{w("explain")}</summary>
      <dl>{rows.map(([name, value]) => <div key={name}><dt>{name.replaceAll("_", " ")}</dt><dd>{typeof value === "object" ? <code>{JSON.stringify(value)}</code> : String(value)}</dd></div>)}</dl>
    </details>
  );
}
