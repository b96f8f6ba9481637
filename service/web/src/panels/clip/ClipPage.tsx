/** One clip: viewer, timeline, and the dock with its views of the document. */
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { subject } from "../../state/session/shell";
import { openClip, type Clip } from "../../state/clip/clip";
import { news } from "../../state/session/events";
import { note } from "../../state/session/notes";
import { bePresent, editing } from "../../state/clip/presence";
import { dockWide, rightFolded, timelineTall } from "../../state/session/panes";
import { param, route } from "../../state/session/route";
import { followProject } from "../../state/library/vocabulary";
import { followProposals, followTerms } from "../../state/clip/review";
import { Splitter } from "../../ui/Splitter";
import { Trouble } from "../../ui/Trouble";
import { w } from "../../words";
import { ClipBar } from "./ClipBar";
import { ReplaceMotion } from "./replacing/ReplaceMotion";
import { Dock } from "./Dock";
import { PosePanel } from "./posing/PosePanel";
import { Similar } from "./similar/Similar";
import { Timeline } from "./timeline/Timeline";
import { Transport } from "./timeline/Transport";
import { ViewerPane } from "./viewer/ViewerPane";
import { useAddress } from "./address";
import { useClipKeys } from "./keys";
import "../../styles/clip.css";

export function ClipPage({ id }: { id: string }) {
  const revision = param("rev") || null;
  return <OpenedClip id={id} revision={revision} key={revision} />;
}

function OpenedClip({ id, revision }: { id: string; revision: string | null }) {
  const [clip, setClip] = useState<Clip | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [turn, setTurn] = useState(0);
  /** Whether the newest is on its way. */
  const coming = useRef(false);
  const reload = () => {
    coming.current = true;
    setTurn((before) => before + 1);
  };
  useEffect(() => {
    const stop = new AbortController();
    let opened: Clip | null = null;
    setError(null);
    openClip(id, revision ? Number(revision) : null, stop.signal).then(
      (found) => {
        opened = found;
        if (stop.signal.aborted) {
          found.close();
          return;
        }
        subject.value = { text: found.detail.name, detail: w("label.revision", { n: found.detail.revision }) };
        coming.current = false;
        setClip((before) => {
          before?.close();
          return found;
        });
      },
      (problem) => !stop.signal.aborted && setError(problem),
    );
    return () => {
      stop.abort();
      opened?.close();
    };
  }, [id, revision, turn]);
  useEffect(() => () => void (subject.value = null), []);
  useEffect(() => (clip ? bePresent(clip.id) : undefined), [clip?.id]);
  const project = clip?.detail.project ?? null;
  useEffect(() => {
    void followProject(project);
    void followTerms(project);
    return () => void followProject(null);
  }, [project]);
  useEffect(() => followProposals(id), [id]);
  if (error || !clip)
    return (
      <>
        <h1 class="unseen">{w("label.clipWord")}</h1>
        {error ? <Trouble error={error} retry={reload} /> : <div class="busy" role="presentation" />}
      </>
    );
  return <OpenClip key={clip.detail.revision} clip={clip} coming={coming} reload={reload} />;
}

function OpenClip({ clip, coming, reload }: { clip: Clip; coming: { readonly current: boolean }; reload: () => void }) {
  useAddress(clip);
  useClipKeys(clip, reload);
  useEffect(() => effect(() => void (editing.value = clip.changed.value && clip.pinned === null)), [clip]);
  // Somebody else saved: said, not imposed.
  useEffect(
    () =>
      effect(() => {
        const one = news.value;
        if (
          !one ||
          one.document !== clip.id ||
          one.revision <= clip.detail.revision ||
          clip.pinned !== null ||
          clip.saving.peek()
        )
          return;
        setTimeout(() => {
          // This window's own save opens the new revision itself.
          if (coming.current || subject.peek()?.detail === w("label.revision", { n: one.revision })) return;
          note(w("help.newer", { who: one.author, n: one.revision }), {
            action: { text: w("button.openNewest"), run: reload },
          });
        }, 1500);
      }),
    [clip],
  );
  const below = param("dock") === "below";
  const [narrow, setNarrow] = useState(innerWidth < 900);
  useEffect(() => {
    const measure = () => setNarrow(innerWidth < 900);
    addEventListener("resize", measure);
    return () => removeEventListener("resize", measure);
  }, []);
  void route.value;
  const under = below || narrow;
  const dock = <Dock clip={clip} reload={reload} />;
  return (
    <div class={`clip ${under ? "under" : ""}`}>
      <div class="clip-main">
        <h1 class="unseen">{clip.detail.name}</h1>
        <ClipBar clip={clip} reload={reload} />
        <ReplaceMotion clip={clip} reload={reload} />
        <div class="viewer-row">
          <ViewerPane clip={clip} />
          <Similar clip={clip} reload={reload} />
          <PosePanel clip={clip} reload={reload} />
        </div>
        <Transport clip={clip} reload={reload} />
        <Splitter size={timelineTall} least={96} most={420} initial={190} axis="y" label={w("label.timeline")} />
        <Timeline clip={clip} />
      </div>
      {!rightFolded.value && (
        <>
          {!under && <Splitter size={dockWide} least={300} most={900} initial={420} label={w("label.dock")} />}
          <aside class="dock" aria-label={w("label.dock")} style={under ? {} : { width: `${dockWide.value}px` }}>
            {dock}
          </aside>
        </>
      )}
    </div>
  );
}
