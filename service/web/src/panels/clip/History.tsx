/** Revisions: who, when, what; a click shows the old pose as a ghost, and how far joints moved between the two. */
import { useEffect, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import type { Clip } from "../../state/clip";
import { note, refuse } from "../../state/notes";
import { setParams } from "../../state/route";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { DifferenceStrip } from "./DifferenceStrip";

export function History({ clip, reload }: { clip: Clip; reload: () => void }) {
  const revisions = useAsync((signal) => get("/documents/{id}/revisions", { path: { id: clip.id }, query: { limit: 200 }, signal }), [clip]);
  const [shown, setShown] = useState<number | null>(null);
  useEffect(() => () => void clip.compare(null), [clip]);
  const show = (number: number) => {
    const next = shown === number ? null : number;
    setShown(next);
    void clip.compare(next);
  };
  const restore = async (revision: number) => {
    try {
      const answer = await ask("post", "/documents/{id}/restore", { path: { id: clip.id }, query: { revision }, match: clip.detail.revision });
      note(w("restoredAs", { n: (answer as { revision: number }).revision }));
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="history">
      <Trouble error={revisions.error} retry={revisions.again} />
      <ol>
        {[...(revisions.value?.items ?? [])].sort((a, b) => b.number - a.number).map((one: Schemas["Revision"]) => (
          <li key={one.number} class={one.number === clip.detail.revision ? "now" : ""}>
            <div class="row"><strong>{one.number}</strong><span class="grow cut">{one.message || one.operation}</span><span class="dim">{when(one.time)}</span></div>
            <div class="row dim">
              <span class="grow cut">{w("author", { who: one.author ?? "local" })}</span>
              {one.number === clip.detail.revision ? <span>{w("thisRevision")}</span> : (
                <>
                  <button type="button" class="button quiet dense" aria-pressed={shown === one.number} onClick={() => show(one.number)}>{w(shown === one.number ? "hideGhost" : "showGhost")}</button>
                  <button type="button" class="button quiet dense" onClick={() => setParams({ rev: String(one.number) }, true)}>{w("open")}</button>
                  {clip.pinned === null && <button type="button" class="button quiet dense" onClick={() => void restore(one.number)}>{w("restore")}</button>}
                </>
              )}
            </div>
            {shown === one.number && <DifferenceStrip clip={clip} />}
          </li>
        ))}
      </ol>
    </div>
  );
}
