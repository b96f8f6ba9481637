/** What an analysis found: each part as its kind says, a picture for a page, and what can be done with it. */
import { entryOf } from "../../lists";
import { useEffect, useState } from "preact/hooks";
import { address, ask, get, type Schemas } from "../../api/client";
import { resultOf } from "../../api/results";
import { subject } from "../../state/session/shell";
import { placeOf } from "../../state/session/jobs";
import { note, refuse } from "../../state/session/notes";
import { go, param, setParams } from "../../state/session/route";
import { analysisTitle } from "../../ui/analyses/titles";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { Operations } from "./Operations";
import { PartView } from "./PartView";
import { a } from "./words";
import "../../styles/analyses.css";

export function ResultPage({ id }: { id: string }) {
  const result = useAsync((signal) => resultOf(id, signal), [id]);
  const catalogue = useAsync((signal) => get("/analyses", { signal }), []);
  const found = result.value;
  const info = catalogue.value?.items.find((one) => one.name === found?.analysis);
  useEffect(() => {
    subject.value = found ? { text: found.name } : null;
  }, [found]);
  const parts = Object.entries(found?.parts ?? {}).sort(
    ([, one], [, other]) => entryOf(RANK, one.kind) - entryOf(RANK, other.kind),
  );
  const shown = param("part") || (info && Object.keys(info.pictures ?? {}).length ? "picture" : parts[0]?.[0]) || "";
  const remove = async () => {
    try {
      await ask("delete", "/results/{id}", { path: { id } });
      note(a("label.resultDeleted"));
      go("/analyses");
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="result">
      <h1 class="unseen">{found?.name ?? w("label.results")}</h1>
      <Trouble error={result.error ?? catalogue.error} retry={result.again} />
      {result.busy && <div class="busy" />}
      {found && info && (
        <>
          <header class="row wrap result-head">
            <div class="grow">
              <h2 class="cut">{found.name}</h2>
              <p class="dim">
                <a href={`/analyses/${info.name}`}>{analysisTitle(info)}</a> ·{" "}
                {a("label.madeFrom", { n: found.inputs.length })} · {when(found.created)}
              </p>
            </div>
            {placeOf(info.name, id) !== `/results/${id}` && (
              <a class="button primary" href={placeOf(info.name, id)}>
                {w("button.open")}
              </a>
            )}
            <Menu
              label={w("label.more")}
              className="button quiet icon"
              side="right"
              items={[{ text: a("button.deleteResult"), icon: "trash", run: () => void remove() }]}
            >
              <Icon name="more" />
            </Menu>
          </header>
          <div class="result-body">
            <nav class="result-parts" aria-label={a("label.parts")}>
              <PartLink name="picture" text={w("label.pictureWord")} shown={shown} />
              {parts.map(([name]) => (
                <PartLink key={name} name={name} text={name} help={info.parts[name]?.description} shown={shown} />
              ))}
            </nav>
            <section class="result-part">
              {shown === "picture" ? (
                <Pictures id={id} info={info} />
              ) : (
                found.parts?.[shown] && (
                  <PartView
                    id={id}
                    name={shown}
                    part={found.parts[shown]}
                    help={info.parts[shown]?.description ?? ""}
                  />
                )
              )}
            </section>
            {found.operations?.length ? <Operations id={id} info={info} names={found.operations} /> : null}
          </div>
        </>
      )}
    </div>
  );
}

const RANK: Record<string, number> = { clip: 0, curve: 1, points: 2, graph: 3, table: 4, model: 5 };

function PartLink({ name, text, help, shown }: { name: string; text: string; help?: string; shown: string }) {
  return (
    <button type="button" aria-pressed={shown === name} title={help} onClick={() => setParams({ part: name }, true)}>
      {text}
    </button>
  );
}

function Pictures({ id, info }: { id: string; info: Schemas["AnalysisInfo"] }) {
  const names = Object.keys(info.pictures ?? {});
  const [chosen, setChosen] = useState(names[0] ?? "");
  const [failed, setFailed] = useState<unknown>(null);
  const [drawn, setDrawn] = useState(false);
  const file = (format: string) => address("/results/{id}/picture", { id }, { name: chosen || undefined, format });
  // An image cannot say why it is none: asked as text, the server can.
  const why = async () => {
    try {
      await get("/results/{id}/picture", { path: { id }, query: chosen ? { name: chosen } : {} });
    } catch (error) {
      setFailed(error);
    }
  };
  return (
    <figure class="result-picture">
      <figcaption class="row wrap">
        {names.length > 1 && (
          <div class="segments" role="group" aria-label={w("label.pictureWord")}>
            {names.map((one) => (
              <button
                key={one}
                type="button"
                aria-pressed={one === chosen}
                onClick={() => {
                  setFailed(null);
                  setDrawn(false);
                  setChosen(one);
                }}
              >
                {one}
              </button>
            ))}
          </div>
        )}
        <span class="grow dim">{info.pictures?.[chosen] ?? w("button.picturesFor")}</span>
        {["svg", "png"].map((format) => (
          <a key={format} class="button dense" href={file(format)} download>
            {a("button.download", { format: format.toUpperCase() })}
          </a>
        ))}
      </figcaption>
      {!drawn && !failed && <div class="busy" />}
      {failed ? (
        <Trouble error={failed} />
      ) : (
        <img
          class={drawn ? "" : "waiting"}
          onLoad={() => setDrawn(true)}
          src={file("svg")}
          alt={info.pictures?.[chosen] ?? w("button.picturesFor")}
          onError={() => void why()}
        />
      )}
    </figure>
  );
}
