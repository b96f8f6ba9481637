/** Proposed changes of the clip: the difference in motion, comments at frames and joints, and the decision. */
import { useEffect, useState } from "preact/hooks";
import { ask, get } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { isPending, loadProposals, proposals, terms, type Proposal } from "../../../state/clip/review";
import { note, refuse } from "../../../state/session/notes";
import { useAsync } from "../../../ui/useAsync";
import { w, when } from "../../../words";
import { Comments } from "../document/Comments";
import { DifferenceStrip } from "../document/DifferenceStrip";
import { undoSaved } from "../keys";
import { r } from "../words";

export function Proposals({ clip, reload }: { clip: Clip; reload: () => void }) {
  const all = proposals.value;
  const pending = all.filter(isPending);
  const ended = all.length - pending.length;
  const [endedToo, setEndedToo] = useState(false);
  const [chosen, setChosen] = useState<number | null>(null);
  // The newest that waits is open: most clips have one.
  const open = chosen ?? pending[0]?.number ?? null;
  return (
    <div class="comments proposals">
      {!pending.length && <p class="dim">{r("help.noProposals")}</p>}
      {ended > 0 && (
        <label class="row">
          <input type="checkbox" checked={endedToo} onChange={() => setEndedToo(!endedToo)} />
          {r("button.endedToo", { n: ended })}
        </label>
      )}
      <ol>
        {(endedToo ? all : pending).map((one) => (
          <li key={one.number} class={isPending(one) ? "" : "dim"}>
            <button
              type="button"
              class="proposal-head"
              aria-expanded={open === one.number}
              onClick={() => setChosen(open === one.number ? 0 : one.number)}
            >
              <span class="row">
                <strong class="grow cut">{one.message || one.summary}</strong>
                <span class="chip">{stateOf(one)}</span>
              </span>
              <span class="row dim">
                <span class="grow cut">
                  {r("label.proposalNumber", { n: one.number })} · {w("label.author", { who: one.author })}
                </span>
                <span>{when(one.created)}</span>
              </span>
            </button>
            {open === one.number && <Review clip={clip} one={one} reload={reload} />}
          </li>
        ))}
      </ol>
    </div>
  );
}

const stateOf = (one: Proposal): string =>
  r(`label.state_${one.state}`, { name: one.reviewer ?? "", n: one.applied ?? 0 });

/** One proposal: its motion as a ghost, what differs, the decision, and what is said about it. */
function Review({ clip, one, reload }: { clip: Clip; one: Proposal; reload: () => void }) {
  const pending = isPending(one);
  const { number, revision } = one;
  useEffect(() => {
    if (pending && clip.pinned === null) void clip.compareProposal(number);
    return () => void clip.compare(null);
  }, [clip, number, revision, pending]);
  return (
    <>
      {one.message && <p>{one.summary}</p>}
      {one.outdated && <p class="dim">{r("help.outdated", { n: revision })}</p>}
      {pending && clip.compared.value && (
        <section aria-label={w("label.difference")} class="history">
          <p class="dim">{r("help.ghostProposed")}</p>
          <DifferenceStrip clip={clip} />
        </section>
      )}
      {pending && <Decision clip={clip} one={one} reload={reload} />}
      <Comments clip={clip} proposal={number} />
    </>
  );
}

/** What a person may do with a proposal that waits. */
function allowedOf(one: Proposal, name: string | undefined, { edits, review }: typeof terms.value) {
  const mine = one.author === name;
  const waits = review && (one.reviewer ?? one.author) === one.author;
  return {
    mine,
    waits: edits && waits,
    approve: edits && one.state === "open" && !(mine && review),
    rebase: one.outdated && (edits || mine),
    apply: edits,
    ready: !waits && !one.outdated,
    close: edits || mine,
  };
}

function Decision({ clip, one, reload }: { clip: Clip; one: Proposal; reload: () => void }) {
  const me = useAsync((signal) => get("/account", { signal }), []);
  const path = { id: clip.id, proposal: one.number };
  const may = allowedOf(one, me.value?.name, terms.value);
  const doing = (work: () => Promise<unknown>) => () => void work().then(loadProposals, refuse);
  const apply = async () => {
    const made = await ask("post", "/documents/{id}/proposals/{proposal}/apply", { path });
    const applied = made.applied ?? clip.detail.revision;
    note(r("label.applied", { n: one.number, revision: applied }), {
      action: { text: w("button.undo"), run: () => void undoSaved(clip, applied, reload) },
    });
    reload();
  };
  const approve = () =>
    ask("put", "/documents/{id}/proposals/{proposal}/approval", { path, query: { revision: one.revision } });
  return (
    <>
      {may.waits && <p class="dim">{r(may.mine ? "help.ownProposal" : "help.needsApproval")}</p>}
      <div class="row wrap">
        {may.approve && (
          <button type="button" class={may.waits ? "button primary" : "button"} onClick={doing(approve)}>
            {r("button.approve")}
          </button>
        )}
        {may.rebase && (
          <button
            type="button"
            class="button"
            onClick={doing(() => ask("post", "/documents/{id}/proposals/{proposal}/rebase", { path }))}
          >
            {r("button.rebase")}
          </button>
        )}
        {may.apply && (
          <button
            type="button"
            class={may.ready ? "button primary" : "button"}
            disabled={!may.ready}
            onClick={doing(apply)}
          >
            {r("button.applyProposal")}
          </button>
        )}
        <span class="grow" />
        {may.close && (
          <button
            type="button"
            class="button quiet"
            onClick={doing(() => ask("post", "/documents/{id}/proposals/{proposal}/close", { path }))}
          >
            {r("button.closeProposal")}
          </button>
        )}
      </div>
    </>
  );
}
