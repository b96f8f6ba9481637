/** Ask the library: editor, answer as a table, its runs playing one after the other. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { EditorView } from "@codemirror/view";
import { address, ask, get, type Schemas } from "../../api/client";
import { copyText } from "../../shell/App";
import { subject } from "../../shell/Bar";
import { offer } from "../../state/keys";
import { note, refuse } from "../../state/notes";
import { askMe, needsToken } from "../../state/me";
import { asked, remember } from "../../state/queries";
import { go, param, setParams } from "../../state/route";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { RunPlayer } from "../../ui/RunPlayer";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { VirtualList } from "../../ui/VirtualList";
import { number, w } from "../../words";
import { kept } from "../../state/settings";
import { ItemCells, ItemHead, OneValue, shapeOf, WholeValue, type Item } from "./Answer";
import { Builder } from "./Builder";
import { mountXPath } from "./editor";
import { Examples } from "./Examples";
import { asCommand, asCurl, asPython } from "./scripts";
import { SavedQueries } from "./SavedQueries";
import "../../styles/xpath.css";

type Run = Schemas["RunItem"];
/** q, project, per: what was asked. single: the answer is one value. */
interface Answered { q: string; project: string; as: "runs" | "json"; type: string; single: boolean; per: boolean; items: (Run | Item)[]; totals: Schemas["RunTotals"] | null; total: number | null; cursor: string | null; ms: number; explain: unknown; complete: boolean; warnings: string[] }

const PIECES = 40; // that an address to the composer holds

const building = kept("builder", true);

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
  const as = param("as") === "nodes" ? ("json" as const) : ("runs" as const);
  const project = param("project");
  const per = param("per") === "document";

  const run = async (query = editor.current?.state.doc.toString() ?? text, cursor: string | null = null, form = param("as") === "nodes" ? "json" as const : "runs" as const): Promise<void> => {
    if (!query.trim()) return;
    stop.current?.abort();
    const { signal } = (stop.current = new AbortController());
    const [project, per] = [param("project"), param("per") === "document"];
    setBusy(true);
    setError(null);
    // Nothing is shown, copied or exported under a question that it does not answer.
    if (!cursor) setAnswer(null);
    const began = performance.now();
    try {
      const found = (await get("/xpath", { query: { q: query, as: form, project: project || undefined, per: per ? "document" : undefined, limit: 500, cursor: cursor ?? undefined, explain: true, otherwise: form === "runs" ? "json" : undefined, with: form === "runs" && !cursor ? "totals" : undefined }, signal })) as Schemas["QueryAnswer"];
      const ms = Math.round(performance.now() - began);
      const items = (found.items ?? [{ value: found.value }]) as Answered["items"];
      setAnswer((before) => ({ q: query, project, as: found.type === "runs" ? "runs" : "json", type: found.type, single: !found.items, per, items: cursor && before ? [...before.items, ...items] : items, totals: found.totals ?? (cursor ? (before?.totals ?? null) : null), total: found.total ?? (cursor ? (before?.total ?? null) : null), cursor: found.next_cursor ?? null, ms, explain: found.explain, complete: found.complete !== false, warnings: found.warnings ?? [] }));
      if (!cursor) { setPicked(0); remember(query); setParams({ q: query }); }
    } catch (problem) {
      if ((problem as Error).name === "AbortError") return;
      setError(problem);
      setAnswer(null);
    } finally {
      if (stop.current.signal === signal) setBusy(false);
    }
  };
  const runNow = useRef(run);
  runNow.current = run;

  useEffect(() => {
    subject.value = null;
    void askMe();
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
      const { q, project } = question;
      const name = slug(q, " ");
      const made = await ask("post", "/compose", { body: { segments: [{ xpath: q, project: project || null, first: 1 }], name } as Schemas["ComposeRequest"] });
      note(w("composed", { name }), { action: { text: w("open"), run: () => go(`/clips/${made.document}`) } });
    } catch (problem) {
      refuse(problem);
    } finally {
      setSaving(false);
    }
  };
  const put = (query: string) => editor.current?.dispatch({ changes: { from: 0, to: editor.current.state.doc.length, insert: query } });
  const write = (query: string) => {
    put(query);
    void run(query);
  };
  const runs = useMemo(() => (answer?.as === "runs" ? (answer.items as Run[]) : []), [answer]);
  const items = useMemo(() => (answer?.as === "json" ? (answer.items as Item[]) : []), [answer]);
  const shape = useMemo(() => shapeOf(items), [items]);
  const open = (row: number) => {
    const [run, item] = [runs[row], items[row]];
    if (run) go(`/clips/${run.document}?f=${run.first}&in=${run.first}&out=${run.last}`);
    else if (item?.document) go(`/clips/${item.document}`);
  };
  const totals = answer?.totals ?? { frames: runs.reduce((sum, one) => sum + one.frames, 0), runs: runs.length, documents: 0 };
  const question = { q: answer?.q ?? text, project: answer?.project ?? project, per: answer?.per ?? per, form: answer?.as ?? as, values: answer?.as === "json" && answer.type !== "nodes", token: needsToken() };
  const copied = question.token ? w("copiedToken") : w("copied");
  const copies = [
    { text: w("asCurl"), run: () => void copyText(asCurl(question, location.origin), copied) },
    { text: w("asCommand"), run: () => void copyText(asCommand(question, location.origin), copied) },
    { text: w("asPython"), run: () => void copyText(asPython(question, location.origin), copied) },
  ];
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
        <button type="button" class="button" aria-pressed={per} title={w("perDocumentHelp")} aria-description={w("perDocumentHelp")} onClick={() => { setParams({ per: per ? null : "document" }); void run(); }}>{w("perDocument")}</button>
        <div class="segments" role="group" aria-label={w("answerAs")}>
          <button type="button" aria-pressed={as === "runs"} onClick={() => { setParams({ as: null }); void run(undefined, null, "runs"); }}>{w("runs")}</button>
          <button type="button" aria-pressed={as === "json"} onClick={() => { setParams({ as: "nodes" }); void run(undefined, null, "json"); }}>{w("nodes")}</button>
        </div>
        <button type="button" class="button" aria-pressed={building.value} onClick={() => (building.value = !building.value)}>{w("builder")}</button>
        <span class="grow" />
        <SavedQueries text={text} onChoose={write} />
        <Menu label={w("queryHistory")} className="button quiet" side="right" items={asked.value.slice(0, 20).map((one) => ({ text: one.length > 70 ? `${one.slice(0, 70)}…` : one, run: () => write(one) }))}>{w("queryHistory")}<Icon name="down" /></Menu>
      </div>
      {building.value && <Builder project={project} text={text} onWrite={put} onRun={() => void run()} />}
      <div class="xpath-editor">
        <div ref={host} class="xpath-host" />
        <button type="button" class="button primary" disabled={!text.trim()} onClick={() => void run()} title="Ctrl+Enter">{w("run")}</button>
      </div>
      {busy && <div class="busy" />}
      <Trouble error={error} />
      {answer && (
        <div class="xpath-status row wrap" role="status">
          <span>{answer.as === "runs" ? w("resultRuns", { frames: w("frames", { n: totals.frames }), runs: w("runCount", { n: totals.runs }), ms: answer.ms }) : w(answer.type === "nodes" ? "resultNodes" : "resultValues", { n: answer.total ?? answer.items.length, ms: answer.ms })}</span>
          {answer.per && <span class="dim" title={w("perDocumentHelp")}>{w("perDocumentAsked")}</span>}
          {answer.cursor && <span class="dim">{w("firstShown", { n: answer.items.length })}</span>}
          {!answer.complete && <span class="cut-off"><Icon name="warn" />{w("cutOff")}</span>}
          {answer.warnings.map((one) => <span key={one} class="dim">{one}</span>)}
          <span class="grow" />
          <Explain explain={answer.explain} />
          <Menu label={w("copy")} className="button quiet dense" side="right" items={copies}>{w("copy")}<Icon name="down" /></Menu>
          <Menu label={w("exportAll")} className="button quiet dense" side="right" items={(["xml", "ndjson", "csv"] as const).map((one) => ({ text: one.toUpperCase(), href: address("/xpath", {}, { q: question.q, project: question.project, as: one, per: question.per ? "document" : undefined }), download: `${slug(question.q)}.${one}` }))}>{w("exportAll")}<Icon name="down" /></Menu>
          {runs.length > 0 && !answer.per && <button type="button" class="button dense" disabled={saving} onClick={() => void saveAsClip()}>{w("saveAsClip")}</button>}
          {runs.length > 0 && <button type="button" class="button dense" onClick={() => go(`/compose?s=${runs.slice(0, PIECES).map((one) => `${one.document}:${one.first}-${one.last}`).join(",")}`)}>{runs.length > PIECES ? w("toComposerFirst", { n: PIECES }) : w("toComposer")}</button>}
        </div>
      )}
      {!answer && !error && !busy && (
        <Examples onChoose={write} />
      )}
      {answer && (answer.items.length === 0 ? <div class="empty"><h2>{w("noAnswer")}</h2><p>{w("noAnswerHelp")}</p></div> : answer.single ? <OneValue item={items[0]} /> : (
        <div class="xpath-answer">
          <div class="xpath-table">
            {answer.as === "json" && <ItemHead shape={shape} />}
            {answer.as === "runs" && <div class="run-row run-head" aria-hidden="true"><span class="n">#</span><span>{w("document")}</span><span class="n">{w("from")}</span><span class="n">{w("last")}</span><span class="n">{w("length")}</span></div>}
            <VirtualList rows={answer.items.length} height={28} label={w("results")} role="listbox" at={picked}
              onSeen={(_, last) => { if (answer.cursor && last >= answer.items.length - 5 && !busy) void run(answer.q, answer.cursor, answer.as); }}
              onKeyDown={(event) => {
                const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
                if (step) { setPicked(Math.max(0, Math.min(answer.items.length - 1, picked + step))); event.preventDefault(); }
                if (event.key === "Enter") open(picked);
              }}
              render={(row) => {
                const item = answer.items[row];
                const props = { role: "option", "aria-selected": row === picked, tabIndex: row === picked ? 0 : -1, onClick: () => setPicked(row) } as const;
                if (answer.as === "runs") {
                  const one = item as Run;
                  return <div class="run-row" {...props} onDblClick={() => open(row)}><span class="n dim">{number(row + 1)}</span><span class="cut">{one.name}</span><span class="n">{number(one.first)}</span><span class="n">{number(one.last)}</span><span class="n dim">{w("frames", { n: one.frames })}</span></div>;
                }
                return <div class={`run-row of-${shape}`} {...props} onDblClick={() => open(row)}><ItemCells item={item as Item} row={row} /></div>;
              }} />
          </div>
          {answer.as === "json" && items[picked] && <WholeValue item={items[picked]} />}
          {runs.length > 0 && <RunPlayer runs={runs} at={picked} onAt={setPicked} />}
        </div>
      ))}
    </div>
  );
}

/** A question as a name: its words. */
const slug = (q: string, between = "-"): string => q.replace(/[^\p{L}\p{N}]+/gu, " ").trim().slice(0, 60).trim().replaceAll(" ", between) || w("untitled");

function Explain({ explain }: { explain: unknown }) {
  if (!explain) return null;
  const rows = Object.entries(explain as Record<string, unknown>).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return (
    <details class="explain"><summary class="button quiet dense">{w("explain")}</summary>
      <dl>{rows.map(([name, value]) => <div key={name}><dt>{name.replaceAll("_", " ")}</dt><dd>{typeof value === "object" ? <code>{JSON.stringify(value)}</code> : String(value)}</dd></div>)}</dl>
    </details>
  );
}
