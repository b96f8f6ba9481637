/** Before there is a map: the takes it is made of, and the maps that were made. */
import { useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { cancelJob, jobs, runAnalysis } from "../../state/session/jobs";
import { go } from "../../state/session/route";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { SchemaForm, type Values } from "../../ui/forms/SchemaForm";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { stageOf } from "../../ui/analyses/titles";
import { f } from "./words";

const DEMO = "demo-face";
const LOOKED_AT = 200; // clips

/** Whether clips with markers are stored; null in libraries of more clips than are looked at. */
async function haveMarkers(signal: AbortSignal): Promise<boolean | null> {
  const page = await get("/documents", { query: { limit: LOOKED_AT, with: "passport" }, signal });
  if (page.items.some((one) => one.passport?.markers)) return true;
  return page.next_cursor ? null : false;
}

export function StartSpace() {
  const info = useAsync((signal) => get("/analyses/{name}", { path: { name: "expression" }, signal }), []);
  const empty = useIsEmpty();
  const marked = useAsync(haveMarkers, [empty]);
  const before = useAsync((signal) => get("/results", { query: { analysis: "expression", limit: 40 }, signal }), []);
  const [values, setValues] = useState<Values>({});
  const [left, setLeft] = useState<ReadonlySet<string>>(new Set());
  const [error, setError] = useState<unknown>(null);
  const [running, setRunning] = useState<string | null>(null);
  const selection = selectionNow();
  const members = useMembers(selection);
  const job = jobs.value.find((one) => one.id === running);
  const build = async (inputs: object) => {
    setError(null);
    try {
      const result = await runAnalysis("expression", { inputs, parameters: values }, (started) =>
        setRunning(started.id),
      );
      go(`/faces/${result}`);
    } catch (refused) {
      if ((refused as Error).name !== "AbortError") setError(refused);
    } finally {
      setRunning(null);
    }
  };
  const chosen = () =>
    left.size ? { documents: members.value!.filter((one) => !left.has(one.id)).map((one) => one.id) } : selection!;
  const maps = (before.value?.items ?? []).filter((one: Schemas["Result"]) => !one.parameters.operation);
  return (
    <div class="faces-start">
      <section>
        <h1>{f("label.title")}</h1>
        <EmptyState
          picture="faces"
          makes={f("help.intro")}
          needs={f("help.needs")}
          missing={marked.value === false ? f("help.missing") : undefined}
          parts={["faces"]}
          busy={running !== null}
          onDemo={() => build({ project: DEMO })}
        />
        <Trouble error={error} />
        {job && (
          <div class="row">
            <progress class="grow" value={job.share} aria-label={stageOf(job)} />
            <span class="dim" role="status">
              {f("label.building", { stage: stageOf(job) })}
            </span>
            <button type="button" class="button" onClick={() => void cancelJob(job)}>
              {w("button.cancel")}
            </button>
          </div>
        )}
        {!empty && <h2>{f("label.recent")}</h2>}
        <Trouble error={before.error} retry={before.again} />
        {!empty && before.value && !maps.length && <p class="dim">{f("help.none")}</p>}
        <ul class="faces-recent">
          {maps.map((one) => (
            <li key={one.id}>
              <a class="cut grow" href={`/faces/${one.id}`}>
                {one.name}
              </a>
              <span class="dim">{when(one.created)}</span>
            </li>
          ))}
        </ul>
      </section>
      {!empty && (
        <form
          onSubmit={(event) => {
            event.preventDefault();
            void build(chosen());
          }}
        >
          <h2>{f("label.takes")}</h2>
          <ClipSelection members={members} left={left} onLeft={setLeft} />
          <details>
            <summary>{f("label.options")}</summary>
            {info.value && <SchemaForm schema={info.value.parameters} values={values} onChange={setValues} />}
          </details>
          <Trouble error={info.error} />
          <p>
            <button type="submit" class="button primary" disabled={!members.value?.length || running !== null}>
              {f("button.build")}
            </button>
          </p>
        </form>
      )}
    </div>
  );
}
