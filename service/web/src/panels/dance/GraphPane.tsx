/** Which bar may follow which: drawn, with a threshold that is tried at once; as a list too. */
import { useMemo, useState } from "preact/hooks";
import { resultOf } from "../../api/results";
import { readAllowed, toggled, writeAllowed } from "../../motion/dance/dancing";
import { cancelJob, jobs, runAnalysis } from "../../state/session/jobs";
import { param, setParams } from "../../state/session/route";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import type { Bench } from "./bench";
import { graphAt, parted, type Graph, type Node } from "./graph";
import { GraphList } from "./GraphList";
import { GraphView } from "./GraphView";
import { stageOf } from "../../ui/analyses/titles";
import { d } from "./words";

const STEPS = 200; // of the threshold's slider

export function GraphPane({ bench }: { bench: Bench }) {
  const [error, setError] = useState<unknown>(null);
  const [running, setRunning] = useState<string | null>(null);
  const [list, setList] = useState(false);
  const [by, setBy] = useState<"clip" | "component">("clip");
  const result = bench.graph.value;
  const corrections = JSON.stringify(bench.steps.now.value);
  const near = param("near") ? Number(param("near")) : null;
  const found = useAsync<Graph | null>(
    async (signal) => (result ? graphAt(result, bench.documents, near, signal) : null),
    [result?.id, near],
  );
  /** While another threshold is asked for, the graph before stays, dimmed. */
  const graph = (found.value === undefined ? found.before : found.value) ?? null;
  const parts = useMemo(() => parted(graph?.components ?? []), [graph]);
  const job = jobs.value.find((one) => one.id === running);
  const make = async () => {
    setError(null);
    try {
      const made = await resultOf(
        await runAnalysis(
          "motion-graph",
          { inputs: { documents: bench.timed }, parameters: { clips: bench.clips } },
          (started) => setRunning(started.id),
        ),
      );
      bench.graphOf.value = corrections;
      bench.graph.value = made;
    } catch (refused) {
      if ((refused as Error).name !== "AbortError") setError(refused);
    } finally {
      setRunning(null);
    }
  };
  const pick = (node: Node) => {
    if (bench.position.peek())
      setParams({ allow: writeAllowed(toggled(readAllowed(param("allow")), bench.position.peek(), node.bar)) || null });
    else bench.shown.value = { kind: "clip", document: node.document, loop: [node.first - 1, node.last - 1] };
    bench.clip.value = node.document;
  };
  const play = (from: Node, to: Node) => {
    bench.shown.value = { kind: "step", from, to };
  };
  const names = (id: string) => bench.found.value.get(id)?.name ?? "";
  const old = result && bench.graphOf.value !== "" && bench.graphOf.value !== corrections;
  return (
    <>
      <div class="row wrap bench-tools">
        <strong>{d("label.graph")}</strong>
        {graph && (
          <span class="dim" role="status" title={d("label.largest", { n: parts.largest })}>
            {d("label.graphOf", { bars: graph.nodes.length, edges: graph.all, components: parts.count })}
          </span>
        )}
        <span class="grow" />
        {graph && (
          <label class="row">
            {d("label.threshold")}
            <input
              type="range"
              min={0}
              max={STEPS}
              value={Math.round((graph.threshold / graph.greatest) * STEPS)}
              aria-valuetext={`${number(graph.threshold, 3)} ${d("label.sizes")}`}
              onInput={(event) =>
                setParams({
                  near: String(Math.round((Number(event.currentTarget.value) / STEPS) * graph.greatest * 1e4) / 1e4),
                })
              }
            />
            <span class="bench-near">{number(graph.threshold, 3)}</span>
          </label>
        )}
        {graph && !list && (
          <button
            type="button"
            class="button dense"
            aria-pressed={by === "component"}
            onClick={() => setBy(by === "clip" ? "component" : "clip")}
          >
            {d("label.byComponent")}
          </button>
        )}
        {graph && (
          <button type="button" class="button dense" aria-pressed={list} onClick={() => setList(!list)}>
            {d("label.asList")}
          </button>
        )}
        {job ? (
          <>
            <progress value={job.share} aria-label={stageOf(job)} />
            <span class="dim" role="status">
              {d("label.making2", { stage: stageOf(job) })}
            </span>
            <button type="button" class="button dense" onClick={() => void cancelJob(job)}>
              {w("button.cancel")}
            </button>
          </>
        ) : (
          <button
            type="button"
            class={`button dense ${result && !old ? "quiet" : "primary"}`}
            disabled={running !== null || bench.rows.value.length === 0}
            onClick={() => void make()}
          >
            {result ? d("button.graphAgain") : d("button.makeGraph")}
          </button>
        )}
      </div>
      {old && <p class="bench-old">{d("help.old")}</p>}
      <Trouble error={error ?? found.error} retry={found.error ? found.again : undefined} />
      {graph ? (
        <div class={`bench-graph-body ${found.value ? "" : "stale"}`} aria-busy={found.busy}>
          {list ? (
            <GraphList graph={graph} names={names} onPick={pick} onPlay={play} />
          ) : (
            <GraphView
              graph={graph}
              by={by}
              names={names}
              chosen={readAllowed(param("allow")).get(bench.position.value) ?? []}
              start={Number(param("start"))}
              onPick={pick}
              onPlay={play}
            />
          )}
        </div>
      ) : (
        !job && (
          <div class="empty bench-hint">
            <p>{d("help.graphHelp")}</p>
          </div>
        )
      )}
    </>
  );
}
