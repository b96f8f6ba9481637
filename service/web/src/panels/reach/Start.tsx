/** Where a model begins: what it needs, the demo's in one press, models that there are, clips and options. */
import { useState } from "preact/hooks";
import { get } from "../../api/client";
import { jobs } from "../../state/session/jobs";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { SchemaForm, type Values } from "../../ui/forms/SchemaForm";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { FitProgress, FitTrouble, useFit } from "./fitting";
import { b } from "./words";

const DEMO = "demo-reach";
const FEWEST = 5; // with three attributes and a straight line, one to leave out

export function Start() {
  const [values, setValues] = useState<Values>({});
  const [name, setName] = useState("");
  const [left, setLeft] = useState<ReadonlySet<string>>(new Set());
  const fit = useFit();
  const empty = useIsEmpty();
  const described = useAsync(
    async (signal) => (await get("/facets", { signal })).properties.some((one) => Boolean(one.numbers)),
    [empty],
  );
  const catalogue = useAsync((signal) => get("/analyses", { signal }), []);
  const selection = selectionNow();
  const members = useMembers(selection);
  const count = (members.value?.length ?? 0) - left.size;
  const info = catalogue.value?.items.find((one) => one.name === "reach");
  const start = (out: ReadonlySet<string> = left) => {
    const inputs = out.size
      ? { documents: members.value!.filter((one) => !out.has(one.id)).map((one) => one.id) }
      : selection;
    void fit.start({ inputs, parameters: values, name: name || undefined });
  };
  const exclude = (documents: string[]) => {
    const next = new Set([...left, ...documents]);
    setLeft(next);
    start(next);
  };
  return (
    <form
      class="reach-start"
      onSubmit={(event) => {
        event.preventDefault();
        start();
      }}
    >
      <section class="start-words">
        <h1>{w("label.reach")}</h1>
        <EmptyState
          picture="reach"
          makes={b("help.intro")}
          needs={b("help.needs")}
          missing={described.value === false ? b("help.missing") : undefined}
          parts={["reaches"]}
          busy={fit.busy}
          onDemo={() => fit.start({ inputs: { project: DEMO }, name: b("label.demoName") })}
        />
        {fit.job && <FitProgress job={fit.job} />}
        <FitTrouble error={fit.error} onExclude={exclude} />
      </section>
      {!empty && (
        <section class="analysis-clips" aria-label={b("label.clipsTitle")}>
          <h2>{b("label.clipsTitle")}</h2>
          <ClipSelection members={members} left={left} onLeft={setLeft} />
          {info && (
            <details class="start-options">
              <summary>{b("label.options")}</summary>
              <SchemaForm schema={info.parameters} values={values} onChange={setValues} leave={["times"]} />
            </details>
          )}
          <div class="schema-field">
            <label for="model-name">{b("label.nameOfModel")}</label>
            <input
              id="model-name"
              class="field"
              value={name}
              placeholder={b("label.namePlaceholder")}
              onInput={(event) => setName(event.currentTarget.value)}
            />
          </div>
          <div class="row">
            <button type="submit" class="button primary" disabled={fit.busy || count < FEWEST}>
              {count >= FEWEST ? b("button.fitClips", { n: count }) : b("button.fit")}
            </button>
            {selection && !members.busy && count < FEWEST && <span class="dim">{b("help.tooFew", { n: FEWEST })}</span>}
          </div>
        </section>
      )}
      {!empty && <Recent />}
      <Trouble error={catalogue.error} />
    </form>
  );
}

function Recent() {
  const found = useAsync(
    (signal) => get("/results", { query: { analysis: "reach", limit: 12 }, signal }),
    [],
    [jobs.value.filter((one) => one.state === "done").length],
  );
  return (
    <aside class="recent" aria-label={b("label.recent")}>
      <h2>{b("label.recent")}</h2>
      <Trouble error={found.error} retry={found.again} />
      {found.value && !found.value.items.length && <p class="dim">{b("help.noModels")}</p>}
      <ul>
        {(found.value?.items ?? []).map((one) => (
          <li key={one.id}>
            <a class="cut block" href={`/reach/${one.id}`}>
              {one.name}
            </a>
            <span class="dim">{[one.project, when(one.created)].filter(Boolean).join(", ")}</span>
          </li>
        ))}
      </ul>
    </aside>
  );
}
