/** Every analysis of the catalogue, each by the form that its schema says: one that is added appears by itself. */
import { useEffect, useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { windowOf, type PageRow } from "../../pages";
import { subject } from "../../state/session/shell";
import { runAnalysis, jobs, cancelJob, type Job } from "../../state/session/jobs";
import { go } from "../../state/session/route";
import { analysisHelp, analysisTitle, stageOf } from "../../ui/analyses/titles";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { SchemaForm, type Values } from "../../ui/forms/SchemaForm";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { a } from "./words";
import "../../styles/analyses.css";

type Info = Schemas["AnalysisInfo"];

export function AnalysesPage({ id }: { id: string }) {
  useEffect(() => {
    subject.value = null;
  }, []);
  const catalogue = useAsync((signal) => get("/analyses", { signal }), []);
  const chosen = catalogue.value?.items.find((one) => one.name === id);
  return (
    <div class="analyses">
      <h1 class="unseen">{w("label.analyses")}</h1>
      <Trouble error={catalogue.error} retry={catalogue.again} />
      {catalogue.busy && <div class="busy" />}
      {id ? chosen && <Form key={id} info={chosen} /> : <Catalogue items={catalogue.value?.items ?? []} />}
    </div>
  );
}

function Catalogue({ items }: { items: Info[] }) {
  return (
    <div class="analyses-list">
      <section>
        <p class="dim lead">{a("help.intro")}</p>
        <ul class="analysis-cards">
          {items.map((one) => (
            <li key={one.name} class="card-plain">
              <h2>
                <a href={`/analyses/${one.name}`}>{analysisTitle(one)}</a>
              </h2>
              <p>{analysisHelp(one)}</p>
              <Window of={windowOf(one.name)} />
            </li>
          ))}
        </ul>
      </section>
      <Recent />
    </div>
  );
}

/** Where an analysis has a page of its own. */
function Window({ of }: { of: PageRow | undefined }) {
  return of ? (
    <p class="dim">
      {a("help.window", { name: w(of.title) })} <a href={of.path}>{w("button.open")}</a>
    </p>
  ) : null;
}

/** Results, of one analysis or all. */
function Recent({ analysis }: { analysis?: string }) {
  const found = useAsync(
    (signal) => get("/results", { query: { analysis, limit: 30 }, signal }),
    [analysis],
    [jobs.value.filter((one) => one.state === "done").length],
  );
  return (
    <aside class="recent" aria-label={w("label.results")}>
      <h2>{a("label.recent")}</h2>
      <Trouble error={found.error} retry={found.again} />
      {found.value && !found.value.items.length && <p class="dim">{a("help.noResults")}</p>}
      <ul>
        {(found.value?.items ?? []).map((one) => (
          <li key={one.id}>
            <a class="cut block" href={`/results/${one.id}`}>
              {one.name}
            </a>
            <span class="dim">{a("label.by", { analysis: one.analysis, when: when(one.created) })}</span>
          </li>
        ))}
      </ul>
      <a href="/jobs">{w("button.allJobs")}</a>
    </aside>
  );
}

function Form({ info }: { info: Info }) {
  const [values, setValues] = useState<Values>({});
  const [name, setName] = useState("");
  const [left, setLeft] = useState<ReadonlySet<string>>(new Set());
  const [error, setError] = useState<unknown>(null);
  const [running, setRunning] = useState<string | null>(null);
  const selection = selectionNow();
  const members = useMembers(selection);
  const count = (members.value?.length ?? 0) - left.size;
  const job = jobs.value.find((one) => one.id === running);
  const start = async () => {
    setError(null);
    const inputs = left.size
      ? { documents: members.value!.filter((one) => !left.has(one.id)).map((one) => one.id) }
      : selection;
    try {
      const result = await runAnalysis(
        info.name,
        { inputs, parameters: values, name: name || undefined },
        (started: Job) => setRunning(started.id),
      );
      go(`/results/${result}`);
    } catch (refused) {
      if ((refused as Error).name !== "AbortError") setError(refused);
    } finally {
      setRunning(null);
    }
  };
  return (
    <form
      class="analysis-form"
      onSubmit={(event) => {
        event.preventDefault();
        void start();
      }}
    >
      <section class="analysis-clips" aria-label={a("label.clipsWord")}>
        <h2>{analysisTitle(info)}</h2>
        <p class="dim">
          {analysisHelp(info)} {a("help.needs", { least: info.fewest, most: info.most })}
        </p>
        <h3>{a("label.clipsWord")}</h3>
        <ClipSelection members={members} left={left} onLeft={setLeft} />
      </section>
      <section class="analysis-options" aria-label={a("label.parameters")}>
        <h3>{a("label.parameters")}</h3>
        <SchemaForm schema={info.parameters} values={values} onChange={setValues} />
        <div class="schema-field">
          <label for="result-name">{a("label.nameOfResult")}</label>
          <input
            id="result-name"
            class="field"
            value={name}
            placeholder={analysisTitle(info)}
            onInput={(event) => setName(event.currentTarget.value)}
          />
        </div>
        <Trouble error={error} />
        <div class="row analysis-run">
          {job ? (
            <>
              <progress class="grow" value={job.share} aria-label={stageOf(job)} />
              <span class="dim">{stageOf(job)}</span>
              <button type="button" class="button" onClick={() => void cancelJob(job)}>
                {w("button.cancel")}
              </button>
            </>
          ) : (
            <>
              <button type="submit" class="button primary" disabled={count < info.fewest || running !== null}>
                {a("button.start", { name: analysisTitle(info) })}
              </button>
              {count < info.fewest && <span class="dim">{a("help.tooFew", { n: info.fewest })}</span>}
            </>
          )}
        </div>
      </section>
      <Recent analysis={info.name} />
    </form>
  );
}
