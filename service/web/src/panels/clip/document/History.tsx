/** Revisions: who, when, what; a click shows the old pose as a ghost, and how far joints moved between the two. */
import { useEffect, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { setParams } from "../../../state/session/route";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w, when } from "../../../words";
import { DifferenceStrip } from "./DifferenceStrip";

export function History({ clip, reload }: { clip: Clip; reload: () => void }) {
  const revisions = useAsync(
    (signal) => get("/documents/{id}/revisions", { path: { id: clip.id }, query: { limit: 200 }, signal }),
    [clip],
  );
  const [shown, setShown] = useState<number | null>(null);
  const [picked, setPicked] = useState<number[]>([]);
  useEffect(() => () => void clip.compare(null), [clip]);
  const show = (number: number) => {
    const next = shown === number ? null : number;
    setShown(next);
    setPicked([]);
    void clip.compare(next);
  };
  /** Two that are picked are compared with each other; of a third the first goes. */
  const pick = (revision: number) => {
    const next = picked.includes(revision) ? picked.filter((one) => one !== revision) : [...picked, revision].slice(-2);
    setPicked(next);
    setShown(null);
    void (next.length === 2 ? clip.compare(Math.min(...next), Math.max(...next)) : clip.compare(null));
  };
  const restore = async (revision: number) => {
    try {
      const answer = await ask("post", "/documents/{id}/restore", {
        path: { id: clip.id },
        query: { revision },
        match: clip.detail.revision,
      });
      note(w("label.restoredAs", { n: (answer as { revision: number }).revision }));
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="history">
      <Trouble error={revisions.error} retry={revisions.again} />
      {(revisions.value?.items.length ?? 0) > 1 && <p class="dim">{w("help.historyHelp")}</p>}
      {picked.length === 2 && (
        <section aria-label={w("label.difference")}>
          <strong>{w("label.differenceOf", { first: Math.min(...picked), last: Math.max(...picked) })}</strong>
          <DifferenceStrip key={picked.join()} clip={clip} />
        </section>
      )}
      <ol>
        {[...(revisions.value?.items ?? [])]
          .sort((a, b) => b.number - a.number)
          .map((one: Schemas["Revision"]) => (
            <li key={one.number} class={one.number === clip.detail.revision ? "now" : ""}>
              <div class="row">
                <label class="row">
                  <input
                    type="checkbox"
                    aria-label={w("button.pickRevision", { n: one.number })}
                    checked={picked.includes(one.number)}
                    onChange={() => pick(one.number)}
                  />
                  <strong>{one.number}</strong>
                </label>
                <span class="grow cut">{one.message || one.operation}</span>
                <span class="dim">{when(one.time)}</span>
              </div>
              <div class="row dim">
                <span class="grow cut">{w("label.author", { who: one.author ?? "local" })}</span>
                {one.number === clip.detail.revision ? (
                  <span>{w("label.thisRevision")}</span>
                ) : (
                  <>
                    <button
                      type="button"
                      class="button quiet dense"
                      aria-pressed={shown === one.number}
                      onClick={() => show(one.number)}
                    >
                      {w(shown === one.number ? "button.hideGhost" : "button.showGhost")}
                    </button>
                    <button
                      type="button"
                      class="button quiet dense"
                      onClick={() => setParams({ rev: String(one.number) }, true)}
                    >
                      {w("button.open")}
                    </button>
                    {clip.pinned === null && (
                      <button type="button" class="button quiet dense" onClick={() => void restore(one.number)}>
                        {w("button.restore")}
                      </button>
                    )}
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
