/**
 * Poses and motions of the library that are similar to one of a clip, beside the viewer. The address has the example, the
 * cut and the scope, and hits keep them: the panel stays open from clip to clip.
 */
import { useEffect, useRef, useState } from "preact/hooks";
import { ask, get } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { param, setParams } from "../../../state/session/route";
import { Icon } from "../../../ui/icons";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";
import { similarAsked } from "../actions";
import { parseExample, within, type Example, type Hit } from "./asked";
import { HitActions } from "./HitActions";
import { HitCard } from "./HitCard";
import "../../../styles/side-panel.css";
import "../../../styles/similar.css";

const HITS = 120;
const AT_ONCE = 12;
const USUAL_CUT = 0.1; // leg lengths
const STEP = 0.005;
const DIGITS = 3;
const KEPT = ["like", "likeof", "likemax", "likein"];

/** Whether the clip that opens next plays at once: it was chosen among the hits. */
let playsNext = false;

export function Similar({ clip, reload }: { clip: Clip; reload: () => void }) {
  const example = parseExample(param("like"));
  useEffect(() => {
    if (playsNext) clip.player.play(1);
    playsNext = false;
  }, [clip]);
  return example && <Found clip={clip} example={example} reload={reload} />;
}

function Found({ clip, example, reload }: { clip: Clip; example: Example; reload: () => void }) {
  const document = param("likeof") || clip.id;
  const own = document === clip.id;
  const here = param("likein") === "project";
  const { first, last } = example;
  const revision = own ? clip.detail.revision : undefined;
  const found = useAsync(
    async (signal) => {
      const of = own ? clip.detail : await get("/documents/{id}", { path: { id: document }, signal });
      const body = { document, revision, first, last, limit: HITS, ...(here ? { project: of.project } : {}) };
      return { name: of.name, ...(await ask("post", "/search", { body, signal })) };
    },
    [document, revision, first, last, here],
  );
  const hits: Hit[] = found.value?.hits ?? [];
  const heading = useRef<HTMLHeadingElement>(null);
  // Asked by a button, the answer is next for keys and in sight; a page that opens with it leaves both alone.
  useEffect(() => {
    if (similarAsked.now) heading.current?.focus();
    similarAsked.now = false;
  }, [document, first, last]);
  const title = titleOf(example, found.value?.name ?? (own ? clip.detail.name : ""));
  return (
    <aside class="side-panel similar" aria-label={title}>
      <header class="row">
        <h2 class="grow" ref={heading} tabIndex={-1}>
          {title}
        </h2>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.close")}
          title={w("button.close")}
          onClick={() => setParams(Object.fromEntries(KEPT.map((one) => [one, null])), true)}
        >
          <Icon name="close" />
        </button>
      </header>
      <div class="segments" role="group" aria-label={w("label.scope")}>
        <button type="button" aria-pressed={!here} onClick={() => setParams({ likein: null })}>
          {w("label.inLibrary")}
        </button>
        <button type="button" aria-pressed={here} onClick={() => setParams({ likein: "project" })}>
          {w("label.inProject")}
        </button>
      </div>
      <Trouble error={found.error} retry={found.again} />
      {found.busy && <Looking />}
      {found.value && !hits.length && <div class="empty">{w("help.nothingAlike")}</div>}
      {hits.length > 0 && (
        <Hits key={title} clip={clip} hits={hits} document={document} poses={last === undefined} reload={reload} />
      )}
      <Warnings texts={found.value?.warnings ?? []} />
    </aside>
  );
}

/** The hits up to the cut, twelve at once, with what can be done with all of them. */
function Hits({
  clip,
  hits,
  document,
  poses,
  reload,
}: {
  clip: Clip;
  hits: Hit[];
  /** Of the example. */
  document: string;
  poses: boolean;
  reload: () => void;
}) {
  const cut = param("likemax") ? Number(param("likemax")) : USUAL_CUT;
  const near = within(hits, cut);
  const [page, setPage] = useState(0);
  const pages = Math.max(1, Math.ceil(near.length / AT_ONCE));
  const at = Math.min(page, pages - 1);
  const shown = near.slice(at * AT_ONCE, (at + 1) * AT_ONCE);
  const onChanged = (documents: string[]) => {
    if (documents.includes(clip.id) && clip.pinned === null && !clip.changed.peek()) reload();
  };
  return (
    <>
      <div class="row">
        <Cut hits={hits} cut={cut} />
        <span class="dim nowrap" role="status">
          {w(near.length === HITS ? "label.nearestHits" : "label.hitsFound", { n: near.length })}
        </span>
      </div>
      <HitActions hits={near} poses={poses} onChanged={onChanged} />
      <ul class="hits" aria-label={w("label.hits")}>
        {shown.map((hit) => (
          <HitCard
            key={`${hit.document} ${hit.first}`}
            hit={hit}
            href={addressOf(hit, document)}
            current={hit.document === clip.id && clip.player.loop.value?.[0] === hit.first - 1}
            onOpen={(event) => play(event, hit, clip)}
          />
        ))}
      </ul>
      {pages > 1 && <Pages at={at} pages={pages} all={near.length} onPage={setPage} />}
    </>
  );
}

const titleOf = ({ first, last }: Example, name: string): string =>
  last
    ? w("label.motionsLikeTitle", { first: number(first), last: number(last), name })
    : w("label.posesLikeTitle", { first: number(first), name });

/** Play a hit of the open clip; one of another clip plays once that is open. */
function play(event: MouseEvent, { document, first, last }: Hit, { id, player }: Clip): void {
  if (event.button || event.metaKey || event.ctrlKey || event.shiftKey) return;
  const moves = last > first;
  player.pause();
  playsNext = moves && document !== id;
  if (document !== id) return;
  event.preventDefault();
  player.loop.value = moves ? [first - 1, last - 1] : null;
  player.seek(first - 1);
  if (moves) player.play(1);
}

/** The address of a hit, with the search that found it. */
function addressOf(hit: Hit, document: string): string {
  const params = new URLSearchParams({ f: String(hit.first) });
  if (hit.last > hit.first) {
    params.set("in", String(hit.first));
    params.set("out", String(hit.last));
  }
  for (const one of ["tab", ...KEPT]) if (param(one)) params.set(one, param(one));
  if (hit.document !== document) params.set("likeof", document);
  else params.delete("likeof");
  return `/clips/${hit.document}?${params}`;
}

const Warnings = ({ texts }: { texts: string[] }) => (
  <>
    {texts.map((text) => (
      <p key={text} class="dim">
        {text}
      </p>
    ))}
  </>
);

const Looking = () => (
  <p class="dim" role="status">
    {w("help.looking")}
  </p>
);

function Cut({ hits, cut }: { hits: Hit[]; cut: number }) {
  const most = Math.max(USUAL_CUT, Math.ceil((hits.at(-1)?.distance ?? 0) / STEP) * STEP);
  return (
    <label class="row grow cut-hits" title={w("help.distanceHelp")}>
      <span>{w("label.distanceUpTo")}</span>
      <input
        class="grow"
        type="range"
        min={0}
        max={most}
        step={STEP}
        value={Math.min(cut, most)}
        aria-valuetext={cut.toFixed(DIGITS)}
        onInput={(event) => setParams({ likemax: event.currentTarget.value })}
      />
      <span class="n">{Math.min(cut, most).toFixed(DIGITS)}</span>
    </label>
  );
}

function Pages({ at, pages, all, onPage }: { at: number; pages: number; all: number; onPage: (page: number) => void }) {
  return (
    <div class="row hit-pages">
      <button type="button" class="button dense" disabled={at === 0} onClick={() => onPage(at - 1)}>
        {w("button.nearerHits")}
      </button>
      <span class="dim grow">
        {w("label.hitsOf", {
          first: at * AT_ONCE + 1,
          last: Math.min(all, (at + 1) * AT_ONCE),
          all,
        })}
      </span>
      <button type="button" class="button dense" disabled={at === pages - 1} onClick={() => onPage(at + 1)}>
        {w("button.moreHits")}
      </button>
    </div>
  );
}
