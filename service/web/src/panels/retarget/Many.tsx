/** The same mapping and body for many clips: chosen, watched one by one, stopped, taken back. */
import { useEffect, useRef, useState } from "preact/hooks";
import { address, fetched, get, type Problem, type Schemas } from "../../api/client";
import { jsonLines } from "../../api/lines";
import * as library from "../../state/library/library";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { problemTitle } from "../../ui/problems/titles";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { SaveTable, Table } from "./Table";

/** schemas/mcml_schemas/retarget.py: RetargetedOne. Streams have no types in the description. */
interface Row {
  source: string;
  name: string;
  made?: Schemas["Retargeted"];
  problem?: Problem;
}
type Kind = "picked" | "collection" | "xpath" | "project";
const LARGE = 20; // degrees: a bone that points so far elsewhere is worth a look
const WAIT = 400; // ms after the last letter

export function Many({
  name,
  request,
  onClose,
}: {
  /** Of the target. */ name: string;
  /** Mapping and options. */ request: object;
  onClose: () => void;
}) {
  const picked = [...library.picked.value];
  const [kind, setKind] = useState<Kind>(picked.length ? "picked" : "collection");
  const [texts, setTexts] = useState({ collection: "", xpath: "", project: "" });
  const [rows, setRows] = useState<Row[]>([]);
  const [table, setTable] = useState<Schemas["RetargetTable"] | null>(null);
  const [state, setState] = useState<"choosing" | "running" | "done" | "stopped">("choosing");
  const [error, setError] = useState<unknown>(null);
  const stop = useRef<AbortController | null>(null);
  const collections = useAsync((signal) => get("/collections", { query: { limit: 100 }, signal }), []);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  useEffect(() => () => stop.current?.abort(), []);

  const text = kind === "picked" ? "" : texts[kind].trim();
  const selection =
    kind === "picked"
      ? { documents: picked }
      : kind === "collection"
        ? { documents: [`collection:${text}`] }
        : { [kind]: text };
  const chosen = kind === "picked" ? picked.length > 0 : text !== "";
  const count = useAsync(
    async (signal) => {
      if (!chosen || kind === "picked") return chosen ? picked.length : null;
      await new Promise((resolve) => setTimeout(resolve, kind === "xpath" ? WAIT : 0));
      signal.throwIfAborted();
      return (await get("/documents", { query: { [kind]: text, limit: 1 }, signal })).total ?? null;
    },
    [kind, text],
  );
  const total = count.error ? null : (count.value ?? null);

  const run = async () => {
    stop.current = new AbortController();
    setRows([]);
    setTable(null);
    setError(null);
    setState("running");
    try {
      const answer = await fetched(address("/retarget", {}, { summary: true }), {
        method: "POST",
        headers: { "content-type": "application/json" },
        body: JSON.stringify({ ...request, selection }),
        signal: stop.current.signal,
      });
      for await (const row of jsonLines<Row | { table: Schemas["RetargetTable"] }>(answer))
        if ("table" in row) setTable(row.table);
        else setRows((before) => [...before, row]);
      setState("done");
    } catch (problem) {
      if ((problem as Error).name === "AbortError") {
        setState("stopped");
        return;
      }
      setError(problem);
      setState("choosing");
    }
  };
  const made = rows.flatMap((one) => (one.made?.document ? [one.made.document] : []));
  const failed = rows.filter((one) => one.problem).length;
  const running = state === "running";
  return (
    <Dialog title={w("button.applyMany", { name })} onClose={onClose} wide>
      {state === "choosing" && (
        <form
          class="many-choose"
          onSubmit={(event) => {
            event.preventDefault();
            if (chosen) void run();
          }}
        >
          <div class="segments" role="group" aria-label={w("label.whichClips")}>
            {(["picked", "collection", "project", "xpath"] as const).map((one) => (
              <button
                key={one}
                type="button"
                aria-pressed={kind === one}
                disabled={one === "picked" && !picked.length}
                onClick={() => setKind(one)}
              >
                {one === "picked"
                  ? w("label.picked", { n: picked.length })
                  : w(one === "collection" ? "label.collections" : `label.${one}`)}
              </button>
            ))}
          </div>
          {kind === "collection" && (
            <Choice
              label={w("label.collections")}
              value={text}
              options={(collections.value?.items ?? []).map((one) =>
                one.project === "default" ? one.name : `${one.project}/${one.name}`,
              )}
              onChange={(collection) => setTexts({ ...texts, collection })}
              empty={w("label.noCollections")}
            />
          )}
          {kind === "project" && (
            <Choice
              label={w("label.project")}
              value={text}
              options={projects.value?.items ?? []}
              onChange={(project) => setTexts({ ...texts, project })}
              empty={w("button.choose")}
            />
          )}
          {kind === "xpath" && (
            <input
              class="field code"
              aria-label={w("label.xpath")}
              placeholder={w("label.queryPlaceholder")}
              value={texts.xpath}
              onInput={(event) => setTexts({ ...texts, xpath: event.currentTarget.value })}
            />
          )}
          <Trouble error={error ?? (chosen ? count.error : null)} />
          <p class="row">
            <span class="grow dim" role="status">
              {chosen && total !== null ? w("label.clips", { n: total }) : w("help.applyHelp")}
            </span>
            <button type="submit" class="button primary" disabled={!chosen || total === 0 || Boolean(count.error)}>
              {w("button.applyNow")}
            </button>
          </p>
        </form>
      )}
      {state !== "choosing" && (
        <>
          <div class="row many-progress">
            <span role="status">
              {running
                ? w("label.manyRunning", { done: rows.length, n: total ?? 0 })
                : w(state === "stopped" ? "help.manyStopped" : "help.manyDone", { n: made.length })}
              {failed > 0 && ` ${w("help.manyFailed", { n: failed })}`}
            </span>
            <progress
              class="grow"
              value={running ? rows.length : 1}
              max={running ? Math.max(1, total ?? 1) : 1}
              aria-label={w("label.retargeting")}
            />
            {running ? (
              <button type="button" class="button" onClick={() => stop.current?.abort()}>
                {w("button.cancel")}
              </button>
            ) : (
              <>
                {made.length > 0 && (
                  <button
                    type="button"
                    class="button"
                    onClick={() => {
                      void library.removeDocuments(made);
                      setRows([]);
                      setState("choosing");
                    }}
                  >
                    {w("button.undo")}
                  </button>
                )}
                <SaveTable table={table} target={name} />
                <button type="button" class="button" onClick={() => setState("choosing")}>
                  {w("button.chooseAgain")}
                </button>
              </>
            )}
          </div>
          <Table table={table} />
          <ul class="many-rows" hidden={table !== null}>
            {rows
              .slice()
              .reverse()
              .map((row) => (
                <Result key={row.source} row={row} />
              ))}
          </ul>
        </>
      )}
    </Dialog>
  );
}

function Choice({
  label,
  value,
  options,
  empty,
  onChange,
}: {
  label: string;
  value: string;
  options: readonly string[];
  empty: string;
  onChange: (value: string) => void;
}) {
  return (
    <select class="field" aria-label={label} value={value} onChange={(event) => onChange(event.currentTarget.value)}>
      <option value="">{options.length ? w("button.choose") : empty}</option>
      {options.map((one) => (
        <option key={one} value={one}>
          {one}
        </option>
      ))}
    </select>
  );
}

function Result({ row }: { row: Row }) {
  const { problem } = row;
  const worst = Math.max(0, ...(row.made?.bones ?? []).filter((one) => one.leads).map((one) => one.largest));
  return (
    <li>
      <div class="row">
        <span class={`state ${problem ? "refused" : "stored"}`}>
          <Icon name={problem ? "warn" : "check"} />
        </span>
        <span class="cut grow">{row.name}</span>
        {row.made && (
          <span class={worst > LARGE ? "guess" : "dim"}>{w("label.manyWorst", { value: number(worst, 1) })}</span>
        )}
        {row.made?.document && (
          <a
            class="button dense"
            href={`/clips/${row.made.document}${row.made.worst_frame ? `?f=${row.made.worst_frame}` : ""}`}
          >
            {w("button.open")}
          </a>
        )}
        {problem && (
          <a class="button quiet dense" href={`/clips/${row.source}`}>
            {w("button.open")}
          </a>
        )}
      </div>
      {problem && (
        <div class="refusal">
          <strong>{problemTitle(problem)}</strong>
          {problem.detail && problem.detail !== problem.title && <p>{problem.detail}</p>}
          {problem.remedy && <p>{problem.remedy}</p>}
        </div>
      )}
    </li>
  );
}
