/** The dance bench: beats and bars of clips, corrected; which bar follows which; a dance to a tempo or to music, with its sound. */
import { useEffect, useMemo, useState } from "preact/hooks";
import type { Schemas } from "../../api/client";
import { resultOf, type Result } from "../../api/results";
import { subject } from "../../state/session/shell";
import { offer } from "../../state/session/keys";
import { refuse } from "../../state/session/notes";
import { param, setParams } from "../../state/session/route";
import { selectionNow, useMembers } from "../../ui/clips/ClipSelection";
import { Tabs } from "../../ui/Tabs";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { benchOf, type Bench, type Corrections } from "./bench";
import { BenchBar } from "./BenchBar";
import { ClipRows } from "./ClipRows";
import { GraphPane } from "./GraphPane";
import { keysOf, setOffset } from "./keys";
import { keptMusic } from "./music";
import { PathStrip } from "./PathStrip";
import { StagePane } from "./StagePane";
import { StartBench } from "./StartBench";
import { d } from "./words";
import "../../styles/analyses.css";
import "../../styles/dance.css";

export function DancePage({ id }: { id: string }) {
  const [choosing, setChoosing] = useState(!id && !selectionNow());
  useEffect(() => {
    subject.value = null;
  }, [id]);
  if (id) return <OfResult id={id} />;
  if (choosing || !selectionNow()) return <StartBench onOpen={() => setChoosing(false)} />;
  return <OfSelection onOthers={() => setChoosing(true)} />;
}

function OfSelection({ onOthers }: { onOthers: () => void }) {
  const members = useMembers(selectionNow());
  const ids = members.busy ? [] : (members.value ?? []).map((one) => one.id).sort();
  return (
    <>
      <Trouble error={members.error} retry={members.again} />
      {members.busy && <div class="busy" />}
      {ids.length > 0 && <Opened key={ids.join()} documents={ids} onOthers={onOthers} />}
      {!members.busy && members.value && !ids.length && <StartBench onOpen={() => undefined} />}
    </>
  );
}

/** A graph or a dance that was made, on the bench of its clips. */
function OfResult({ id }: { id: string }) {
  const result = useAsync((signal) => resultOf(id, signal), [id]);
  const found = result.value;
  useEffect(() => {
    if (found) subject.value = { text: found.name };
  }, [found]);
  return (
    <>
      <h1 class="unseen">{d("label.title")}</h1>
      <Trouble error={result.error} retry={result.again} />
      {result.busy && <div class="busy" />}
      {found && <Opened documents={found.inputs.map((one) => one.document).sort()} result={found} />}
    </>
  );
}

/** The corrections that a result was made with. */
function correctionsOf(result: Result): Corrections {
  const clips = (result.parameters.clips ?? []) as {
    document: string;
    beats?: number[] | null;
    source_bpm?: number | null;
    beats_from?: string | null;
  }[];
  return Object.fromEntries(
    clips.map((one) => [
      one.document,
      {
        ...(one.beats ? { beats: one.beats.map((at) => ({ at, kind: "hand" as const })) } : {}),
        ...(one.source_bpm ? { source_bpm: one.source_bpm } : {}),
        ...(one.beats_from && one.beats_from !== "auto" ? { beats_from: one.beats_from as "tracked" } : {}),
      },
    ]),
  );
}

const TABS = ["beats", "graph", "stage"] as const;

function Opened({ documents, result, onOthers }: { documents: string[]; result?: Result; onOthers?: () => void }) {
  const bench = useMemo<Bench>(() => {
    const made = benchOf(documents, result && correctionsOf(result));
    if (result?.analysis === "motion-graph") made.graph.value = result;
    if (result?.analysis === "dance" && !result.parts.clip) made.dry.value = result;
    if (result?.analysis === "dance" && result.parts.clip) made.shown.value = { kind: "dance", result };
    if (result) {
      const given = result.parameters as { bpm?: number | null; bars?: number };
      setParams({
        ...(given.bpm && !param("bpm") ? { bpm: String(given.bpm) } : {}),
        ...(given.bars && !param("bars") ? { bars: String(given.bars) } : {}),
      });
    }
    return made;
  }, [documents.join(), result?.id]);
  const tab = TABS.find((one) => one === param("tab")) ?? (result?.parts.clip ? "stage" : "beats");
  useEffect(() => offer("dance", keysOf(bench)), [bench]);
  useEffect(() => {
    const stop = new AbortController();
    const [document, given] = [
      result?.parts.clip?.document,
      result?.parameters.music as Schemas["Music"] | null | undefined,
    ];
    if (document && given && !bench.music.peek())
      keptMusic(document, given, stop.signal).then((kept) => {
        if (!kept || stop.signal.aborted) return;
        bench.music.value = kept.music;
        setOffset(kept.offset);
      }, refuse);
    return () => stop.abort();
  }, [bench, result?.id]);
  return (
    <div class={`bench at-${tab}`}>
      {!result && <h1 class="unseen">{d("label.title")}</h1>}
      <BenchBar bench={bench} onOthers={onOthers} />
      <div class="bench-tabs">
        <Tabs
          label={d("label.title")}
          tabs={[
            { id: "beats", text: d("label.beatsTab") },
            { id: "graph", text: d("label.graph") },
            { id: "stage", text: d("label.stage") },
          ]}
          open={tab}
          onOpen={(one) => setParams({ tab: one })}
        />
      </div>
      <section class="bench-clips" id="panel-beats" aria-label={d("label.beatsTab")}>
        <ClipRows bench={bench} />
      </section>
      <div class="bench-lower">
        <section class="bench-graph" id="panel-graph" aria-label={d("label.graph")}>
          <GraphPane bench={bench} />
          <PathStrip bench={bench} made={result} />
        </section>
        <section class="bench-stage" id="panel-stage" aria-label={d("label.stage")}>
          <StagePane bench={bench} />
        </section>
      </div>
    </div>
  );
}
