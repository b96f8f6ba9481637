/** Measure many clips: curves of groups, a table with outliers first, and files of both. The address has everything. */
import { useCallback, useEffect, useMemo, useRef } from "preact/hooks";
import { ask, get } from "../../api/client";
import { refuse } from "../../state/session/notes";
import { param, setParams } from "../../state/session/route";
import { subject } from "../../state/session/shell";
import { analysisTitle } from "../../ui/analyses/titles";
import { selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { Icon } from "../../ui/icons";
import { RunPlayer } from "../../ui/playing/RunPlayer";
import { EmptyState, useIsEmpty } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { CurvePlot } from "./CurvePlot";
import { FORMS, savePlots, saveTable } from "./download";
import {
  GAIT,
  keyOf,
  MOST_ROWS,
  readAsked,
  requestOf,
  rowsOf,
  writeQuantities,
  type Measures,
  type Row,
} from "./request";
import { windowOf } from "../../pages";
import { Rows } from "./Rows";
import { Setup } from "./Setup";
import { w } from "../../words";
import { m } from "./words";
import "../../styles/analyses.css";
import "../../styles/measure.css";

const DEMO = "demo-walk";
/** Plots on the page; the downloads have all groups. */
const MOST_PLOTS = 60;

type Request = NonNullable<ReturnType<typeof requestOf>>;

export function MeasurePage() {
  useEffect(() => {
    subject.value = null;
  }, []);
  const selection = selectionNow();
  const members = useMembers(selection);
  const asked = readAsked(param);
  const request = requestOf(selection, asked);
  const found = useAsync<Measures | null>(
    (signal) =>
      request
        ? ask("post", "/measure", {
            body: {
              ...request,
              guesses: "yes",
              as: "json",
              table: "ranges",
              curves: true,
              limit: MOST_ROWS,
              raw: false,
            },
            signal,
          })
        : Promise.resolve(null),
    [JSON.stringify(request)],
  );
  const shown = found.value ?? (request ? found.before : null);
  if (useIsEmpty())
    return (
      <section class="empty-page">
        <h1 class="unseen">{w("label.measure")}</h1>
        <Invitation chosen={false} />
      </section>
    );
  return (
    <div class="measure">
      <Setup asked={asked} members={members} />
      <section class="measure-main" aria-label={m("label.result")}>
        <Trouble error={found.error} retry={found.again} />
        {request && found.busy && <div class="busy" />}
        {request && shown ? (
          <Result found={shown} request={request} />
        ) : (
          !request && <Start chosen={selection !== null} />
        )}
      </section>
    </div>
  );
}

const Invitation = ({ chosen }: { chosen: boolean }) => (
  <EmptyState
    picture="measure"
    makes={m("help.intro")}
    needs={m(chosen ? "help.add" : "help.first")}
    parts={["walks"]}
    onDemo={() => setParams({ project: DEMO, ranges: "strides", m: writeQuantities(GAIT) })}
  />
);

/** What a visitor sees before anything is measured. */
function Start({ chosen }: { chosen: boolean }) {
  const analyses = useAsync((signal) => get("/analyses", { signal }), []);
  return (
    <div class="measure-start">
      <Invitation chosen={chosen} />
      <h2>{w("label.analyses")}</h2>
      <ul>
        {(analyses.value?.items ?? []).map((one) => (
          <li key={one.name}>
            <a href={windowOf(one.name)?.path ?? `/analyses/${one.name}`}>{analysisTitle(one)}</a>
          </li>
        ))}
      </ul>
      <a href="/analyses">{m("button.allAnalyses")}</a>
    </div>
  );
}

function Result({ found, request }: { found: Measures; request: Request }) {
  const plots = useRef<HTMLDivElement>(null);
  const picked = param("row");
  const pick = useCallback((row: Row) => setParams({ row: keyOf(row) }), []);
  const row = useMemo(() => found.ranges.find((one) => keyOf(one) === picked), [found, picked]);
  const groups = useMemo(() => found.groups.map((group) => ({ group, rows: rowsOf(group, found.ranges) })), [found]);
  return (
    <>
      <div class="row wrap measure-tools">
        {FORMS.map((form) => (
          <button
            type="button"
            key={form}
            class="button dense"
            disabled={!found.total_ranges}
            onClick={() => void saveTable(request, form).catch(refuse)}
          >
            {m("button.download", { format: form === "parquet" ? "Parquet" : form.toUpperCase() })}
          </button>
        ))}
        <button
          type="button"
          class="button dense"
          disabled={!groups.length}
          onClick={() => plots.current && savePlots(plots.current)}
        >
          {m("button.download", { format: "SVG" })}
        </button>
      </div>
      {found.warnings.length > 0 && (
        <details class="measure-notes" open={!found.total_ranges}>
          <summary>{m("label.notes", { n: found.warnings.length })}</summary>
          <ul>
            {found.warnings.map((text) => (
              <li key={text}>{text}</li>
            ))}
          </ul>
        </details>
      )}
      {!found.total_ranges && <p>{m("help.none")}</p>}
      {row && <Playing row={row} />}
      {groups.length > 0 && (
        <section aria-label={m("label.curves")}>
          <h2>{m("label.curves")}</h2>
          <p class="dim">{m("help.curves")}</p>
          <div class="measure-plots" ref={plots}>
            {groups.slice(0, MOST_PLOTS).map(({ group, rows }) => (
              <CurvePlot
                key={`${group.quantity} ${JSON.stringify(group.group)}`}
                group={group}
                rows={rows}
                picked={picked}
                onPick={pick}
              />
            ))}
          </div>
          {found.total_groups > MOST_PLOTS && (
            <p class="dim">{m("label.moreGroups", { n: found.total_groups - MOST_PLOTS })}</p>
          )}
        </section>
      )}
      {found.total_ranges > 0 && <Rows found={found} picked={picked} onPick={pick} />}
    </>
  );
}

function Playing({ row }: { row: Row }) {
  const runs = useMemo(() => [row], [row]);
  return (
    <div class="measure-player">
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={m("button.close")}
        onClick={() => setParams({ row: null })}
      >
        <Icon name="close" />
      </button>
      <RunPlayer runs={runs} at={0} onAt={() => undefined} />
    </div>
  );
}
