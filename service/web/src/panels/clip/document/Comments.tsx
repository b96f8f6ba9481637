/** What people say about the clip, or about one proposal: a click goes to the frames and the joint that it is about. */
import { useEffect, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { commented } from "../../../state/session/events";
import { refuse } from "../../../state/session/notes";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { w, when } from "../../../words";
import { r } from "../words";

type Comment = Schemas["CommentView"];

export function Comments({ clip, proposal }: { clip: Clip; proposal?: number }) {
  const id = clip.id;
  const me = useAsync((signal) => get("/account", { signal }), []);
  const found = useAsync(
    (signal) =>
      get("/documents/{id}/comments", {
        path: { id },
        query: { limit: 1000, ...(proposal === undefined ? {} : { proposal }) },
        signal,
      }),
    [id, proposal],
  );
  const [settled, setSettled] = useState(false);
  useEffect(
    () =>
      commented.subscribe((one) => {
        if (one?.document === id) found.again();
      }),
    [id],
  );
  const doing = async (work: () => Promise<unknown>) => {
    try {
      await work();
      found.again();
    } catch (error) {
      refuse(error);
    }
  };
  const all = found.value?.items ?? [];
  const done = all.filter((one) => one.resolved).length;
  return (
    <div class="comments">
      <Trouble error={found.error} retry={found.again} />
      <Say
        clip={clip}
        say={(said) => {
          const body = proposal === undefined ? said : { ...said, proposal };
          return doing(() => ask("post", "/documents/{id}/comments", { path: { id }, body }));
        }}
      />
      {found.value && !all.length && <p class="dim">{w("help.noComments")}</p>}
      {done > 0 && (
        <label class="row">
          <input type="checkbox" checked={settled} onChange={() => setSettled(!settled)} />
          {w("button.resolvedToo", { n: done })}
        </label>
      )}
      <ol>
        {all
          .filter((one) => settled || !one.resolved)
          .map((one) => (
            <li key={one.id} class={one.resolved ? "dim" : ""}>
              <div class="row dim">
                <span class="grow cut">{one.author}</span>
                <span>
                  {when(one.created)}
                  {one.edited && ` · ${w("label.edited")}`}
                </span>
              </div>
              {one.proposal && proposal === undefined && (
                <span class="chip">{r("label.proposalNumber", { n: one.proposal })}</span>
              )}
              <p>{one.text}</p>
              <div class="row wrap">
                <Place clip={clip} comment={one} />
                <span class="grow" />
                <button
                  type="button"
                  class="button quiet dense"
                  onClick={() =>
                    void doing(() =>
                      ask(one.resolved ? "delete" : "put", "/documents/{id}/comments/{comment}/resolved", {
                        path: { id, comment: one.id },
                      }),
                    )
                  }
                >
                  {w(one.resolved ? "button.reopenComment" : "button.resolveComment")}
                </button>
                {one.author === me.value?.name && (
                  <button
                    type="button"
                    class="button quiet dense"
                    onClick={() =>
                      void doing(() =>
                        ask("delete", "/documents/{id}/comments/{comment}", { path: { id, comment: one.id } }),
                      )
                    }
                  >
                    {w("button.deleteComment")}
                  </button>
                )}
              </div>
            </li>
          ))}
      </ol>
    </div>
  );
}

/** The frames that a comment is about, in the revision that is shown; null where it has none of them. */
function framesHere(clip: Clip, { revision, first, last, first_now, last_now }: Comment): [number, number] | null {
  if (revision === clip.detail.revision) return first ? [first, last ?? first] : null;
  return clip.pinned === null && first_now ? [first_now, last_now ?? first_now] : null;
}

const framesText = (first: number, last: number): string =>
  last > first ? w("label.commentFrames", { first, last }) : w("label.commentFrame", { n: first });

/** What a comment is about, as a button that goes there; frames that were deleted, as a link to their revision. */
function Place({ clip, comment }: { clip: Clip; comment: Comment }) {
  const { first, last, bone } = comment;
  const old = comment.revision !== clip.detail.revision && (
    <span class="dim">{w("label.revision", { n: comment.revision })}</span>
  );
  if (!first && !bone) return <>{old}</>;
  const here = framesHere(clip, comment);
  if (first && !here) {
    const there = new URLSearchParams({ rev: String(comment.revision), f: String(first), tab: "comments" });
    return (
      <a class="button dense" href={`/clips/${clip.id}?${there}`} title={r("help.notHere")}>
        {[framesText(first, last ?? first), bone].filter(Boolean).join(", ")} ·{" "}
        {w("label.revision", { n: comment.revision })}
      </a>
    );
  }
  const go = () => {
    if (here) {
      clip.player.pause();
      clip.player.seek(here[0] - 1);
    }
    if (bone) clip.select([bone]);
  };
  return (
    <>
      <button type="button" class="button dense" onClick={go}>
        {[here && framesText(...here), bone].filter(Boolean).join(", ")}
      </button>
      {old}
    </>
  );
}

/** A new comment: about the clip, or the frame at the playhead (the stretch that repeats), or the joint that is selected. */
function Say({ clip, say }: { clip: Clip; say: (body: Schemas["CommentRequest"]) => Promise<void> }) {
  const [text, setText] = useState("");
  const [here, setHere] = useState(true);
  const [joint, setJoint] = useState(true);
  const frame = clip.player.frame.value;
  const [first, last] = clip.player.loop.value ?? [frame, frame];
  const bone = clip.selection.value.bones.at(-1);
  const send = async () => {
    const frames = here && clip.detail.frames ? { first: first + 1, last: last + 1 } : {};
    await say({ text, revision: clip.detail.revision, ...frames, ...(joint && bone ? { bone } : {}) });
    setText("");
  };
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (text.trim()) void send();
      }}
    >
      <textarea
        class="field"
        rows={3}
        maxLength={4000}
        aria-label={w("label.newComment")}
        placeholder={w("label.newComment")}
        value={text}
        onInput={(event) => setText(event.currentTarget.value)}
      />
      <div class="row wrap">
        {clip.detail.frames > 0 && (
          <label class="row">
            <input type="checkbox" checked={here} onChange={() => setHere(!here)} />
            {last > first
              ? w("label.commentFrames", { first: first + 1, last: last + 1 })
              : w("label.commentFrame", { n: first + 1 })}
          </label>
        )}
        {bone && (
          <label class="row">
            <input type="checkbox" checked={joint} onChange={() => setJoint(!joint)} />
            {bone}
          </label>
        )}
        <span class="grow" />
        <button type="submit" class="button" disabled={!text.trim()}>
          {w("button.addComment")}
        </button>
      </div>
    </form>
  );
}
