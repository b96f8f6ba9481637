/** Clips that follow a hand: keys, a game pad or a path lead a body, and what it does is stored as a clip. */
import { useEffect, useMemo, useState } from "preact/hooks";
import { setParams } from "../../state/session/route";
import { subject } from "../../state/session/shell";
import { ClipSelection, selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { load, type Loaded } from "./loading";
import { Session } from "./session";
import { Steering } from "./Steering";
import { m } from "./words";
import "../../styles/analyses.css";
import "../../styles/matching.css";

const DEMO = "demo-walk";

export function MatchingPage() {
  const selection = selectionNow();
  const members = useMembers(selection);
  const empty = useIsEmpty();
  const [progress, setProgress] = useState<[number, number] | null>(null);
  const loaded = useAsync<Loaded | null>(
    async (signal) => (selection ? load(selection, signal, (...done) => setProgress(done)) : null),
    [JSON.stringify(selection)],
  );
  const ready = loaded.value ?? null;
  const session = useMemo(() => (ready ? new Session(ready) : null), [ready]);
  useEffect(() => {
    subject.value = null;
    return () => session?.pause();
  }, [session]);
  const start = (
    <EmptyState
      picture="matching"
      makes={m("help.intro")}
      needs={m("help.needs")}
      parts={["walks"]}
      onDemo={() => setParams({ project: DEMO })}
    />
  );
  if (empty)
    return (
      <section class="empty-page">
        <h1 class="unseen">{w("label.matching")}</h1>
        {start}
      </section>
    );
  return (
    <div class="matching">
      <aside class="matching-clips" aria-label={m("label.clips")}>
        <h1>{w("label.matching")}</h1>
        {selection && <p class="dim">{m("help.intro")}</p>}
        {ready && <Facts loaded={ready} />}
        <ClipSelection members={members} />
      </aside>
      <section class="matching-main" aria-label={m("label.stage")}>
        <Trouble error={loaded.error} retry={loaded.again} />
        {session ? (
          <Steering key={JSON.stringify(selection)} session={session} project={selection?.project ?? "default"} />
        ) : loaded.busy && selection ? (
          <div class="empty">
            <p role="status">{progress && m("label.loading", { n: progress[0], all: progress[1] })}</p>
          </div>
        ) : (
          !loaded.error && start
        )}
      </section>
    </div>
  );
}

function Facts({ loaded }: { loaded: Loaded }) {
  const { left_out: left } = loaded.facts;
  const minutes = number(loaded.minutes, 1);
  return (
    <div class="matching-facts">
      <p role="status">{m("label.library", { minutes, n: loaded.clips.length })}</p>
      {loaded.cut && <p class="notice">{m("help.onlyFirst", { minutes })}</p>}
      {left.length > 0 && (
        <details>
          <summary>{m("label.leftOut", { n: left.length })}</summary>
          <ul>
            {left.map((one) => (
              <li key={one.document}>
                <a href={`/clips/${one.document}`}>{one.name}</a>: {one.reason}
              </li>
            ))}
          </ul>
        </details>
      )}
    </div>
  );
}
