/** Before there is a bench: the clips it is made of, and what was made of others. */
import { useState } from "preact/hooks";
import { get } from "../../api/client";
import { go } from "../../state/session/route";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { when } from "../../words";
import { d } from "./words";

const DEMO = "demo-dance";
const MOST_NAMED = 60; // clips that an address names one by one

export function StartBench({ onOpen }: { onOpen: () => void }) {
  const [left, setLeft] = useState<ReadonlySet<string>>(new Set());
  const members = useMembers(selectionNow());
  const empty = useIsEmpty();
  const before = useAsync(async (signal) => {
    const found = await Promise.all(
      ["dance", "motion-graph"].map((analysis) => get("/results", { query: { analysis, limit: 20 }, signal })),
    );
    return found.flatMap((page) => page.items).sort((a, b) => b.created.localeCompare(a.created));
  }, []);
  const open = (ids: string[]) => {
    // By their ids: dances that are made of them are not among them.
    if (ids.length <= MOST_NAMED) go(`/dance?${new URLSearchParams(ids.map((id) => ["doc", id]))}`);
    onOpen();
  };
  const demo = async () =>
    open(
      (await get("/documents", { query: { project: DEMO, motion_name: undefined, limit: MOST_NAMED } })).items
        .filter((one) => /_\d+$/.test(one.name))
        .map((one) => one.id),
    );
  const chosen = (members.value ?? []).filter((one) => !left.has(one.id)).map((one) => one.id);
  return (
    <div class="bench-start">
      <section>
        <h1>{d("label.title")}</h1>
        <EmptyState picture="dance" makes={d("help.intro")} parts={["dances"]} onDemo={demo} />
        {!empty && <h2>{d("label.recent")}</h2>}
        <Trouble error={before.error} retry={before.again} />
        {!empty && before.value && !before.value.length && <p class="dim">{d("help.none")}</p>}
        <ul class="bench-recent">
          {(before.value ?? []).map((one) => (
            <li key={one.id}>
              <a class="cut grow" href={`/dance/${one.id}`}>
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
            open(chosen);
          }}
        >
          <h2>{d("label.clipsWord")}</h2>
          <p class="dim">{d("help.needs")}</p>
          <ClipSelection members={members} left={left} onLeft={setLeft} />
          <p>
            <button type="submit" class="button primary" disabled={members.busy || !chosen.length}>
              {d("button.openBench")}
            </button>
          </p>
        </form>
      )}
    </div>
  );
}
