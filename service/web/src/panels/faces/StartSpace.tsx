/** Before there is a map: the takes it is made of, and the maps that were made. */
import { useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { cancelJob, jobs, runAnalysis } from "../../state/session/jobs";
import { go } from "../../state/session/route";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { SchemaForm, type Values } from "../../ui/forms/SchemaForm";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { f } from "./words";

const DEMO = "demo-face";

export function StartSpace() {
  const info = useAsync((signal) => get("/analyses/{name}", { path: { name: "expression" }, signal }), []);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
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
        <p>{f("help.intro")}</p>
        <p class="dim">{f("help.needs")}</p>
        {projects.value?.items.includes(DEMO) && (
          <p>
            <button
              type="button"
              class="button primary"
              disabled={running !== null}
              onClick={() => void build({ project: DEMO })}
            >
              {f("button.demo")}
            </button>
          </p>
        )}
        <Trouble error={error} />
        {job && (
          <div class="row">
            <progress class="grow" value={job.share} aria-label={job.stage ?? ""} />
            <span class="dim" role="status">
              {f("label.building", { stage: job.stage ?? "" })}
            </span>
            <button type="button" class="button" onClick={() => void cancelJob(job)}>
              {w("button.cancel")}
            </button>
          </div>
        )}
        <h2>{f("label.recent")}</h2>
        <Trouble error={before.error} retry={before.again} />
        {before.value && !maps.length && <p class="dim">{f("help.none")}</p>}
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
      <form
        onSubmit={(event) => {
          event.preventDefault();
          void build(chosen());
        }}
      >
        <h2>{f("label.takes")}</h2>
        <ClipSelection
          members={members}
          left={left}
          onLeft={(one, out) => {
            const next = new Set(left);
            if (out) next.add(one);
            else next.delete(one);
            setLeft(next);
          }}
        />
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
    </div>
  );
}
