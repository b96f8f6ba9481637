/** The places of the library that are most like a pose or a motion of a clip. */
import { itemAt } from "../../../lists";
import { useState } from "preact/hooks";
import { ask, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { Dialog } from "../../../ui/Dialog";
import { RunPlayer } from "../../../ui/playing/RunPlayer";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { VirtualList } from "../../../ui/VirtualList";
import { number, w } from "../../../words";

const HITS = 60;
const ROW = 28;
const DIGITS = 3;

/** first, last: frames from 1; without the last one it is a pose. */
export function Alike({
  clip,
  first,
  last,
  onClose,
}: {
  clip: Clip;
  first: number;
  last?: number;
  onClose: () => void;
}) {
  const found = useAsync(
    (signal) =>
      ask("post", "/search", {
        body: { document: clip.id, revision: clip.detail.revision, first, last, limit: HITS },
        signal,
      }),
    [],
  );
  const [picked, setPicked] = useState(0);
  const hits: Schemas["SearchHit"][] = found.value?.hits ?? [];
  const title = last
    ? w("label.motionsLikeTitle", { first: number(first), last: number(last), name: clip.detail.name })
    : w("label.posesLikeTitle", { first: number(first), name: clip.detail.name });
  return (
    <Dialog title={title} onClose={onClose} wide>
      <Trouble error={found.error} retry={found.again} />
      {found.busy && (
        <>
          <div class="busy" />
          <p class="dim" role="status">
            {w("help.looking")}
          </p>
        </>
      )}
      {found.value && !hits.length && <div class="empty">{w("help.nothingAlike")}</div>}
      {hits.length > 0 && (
        <div class="alike">
          <div class="alike-list">
            <div class="run-row run-head">
              <span>{w("label.name")}</span>
              <span class="n">{w("label.framesWord")}</span>
              <span class="n" title={w("help.distanceHelp")}>
                {w("label.distance")}
              </span>
            </div>
            <VirtualList
              rows={hits.length}
              height={ROW}
              label={title}
              role="listbox"
              at={picked}
              onKeyDown={(event) => {
                const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
                if (step) {
                  setPicked(Math.max(0, Math.min(hits.length - 1, picked + step)));
                  event.preventDefault();
                }
              }}
              render={(row) => {
                const hit = itemAt(hits, row);
                return (
                  <div
                    class="run-row"
                    role="option"
                    aria-selected={row === picked}
                    tabIndex={row === picked ? 0 : -1}
                    onClick={() => setPicked(row)}
                  >
                    <span class="cut">{hit.name}</span>
                    <span class="n">
                      {number(hit.first)}
                      {hit.last > hit.first && `–${number(hit.last)}`}
                    </span>
                    <span class="n">{hit.distance.toFixed(DIGITS)}</span>
                  </div>
                );
              }}
            />
          </div>
          <RunPlayer runs={hits} at={picked} onAt={setPicked} />
        </div>
      )}
      {(found.value?.warnings ?? []).map((text) => (
        <p key={text} class="dim">
          {text}
        </p>
      ))}
    </Dialog>
  );
}
