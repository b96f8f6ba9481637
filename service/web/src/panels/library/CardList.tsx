/** The same clips as rows of a table. */
import { useState } from "preact/hooks";
import * as library from "../../state/library/library";
import { go } from "../../state/session/route";
import { ThumbnailView } from "../../ui/clips/ThumbnailView";
import { VirtualList } from "../../ui/VirtualList";
import { duration, number, rate, w, when } from "../../words";
import { pickBy } from "./picking";
import { SpanStrip } from "./CardView";
import { SortHeading } from "./SortMenu";

const TALL = 44;

export function CardList() {
  const [focus, setFocus] = useState(0);
  void library.version.value;
  const total = library.total.value ?? 12;
  return (
    <div class="card-list">
      <div class="list-row list-head" role="group" aria-label={w("label.sort")}>
        <span />
        <SortHeading column="name" />
        <SortHeading column="project" />
        <SortHeading column="format" />
        <SortHeading column="duration" numeric />
        <SortHeading column="rate" word="label.rateWord" numeric />
        <span>{w("label.names")}</span>
        <SortHeading column="modified" />
      </div>
      <VirtualList
        rows={total}
        height={TALL}
        label={w("label.library")}
        role="grid"
        at={focus}
        onSeen={(first, last) => library.look(Math.max(0, first), Math.min(total - 1, last))}
        onKeyDown={(event) => {
          const step = { ArrowUp: -1, ArrowDown: 1, PageUp: -10, PageDown: 10, Home: -focus, End: total }[event.key];
          if (step === undefined) return;
          event.preventDefault();
          const next = Math.max(0, Math.min(total - 1, focus + step));
          setFocus(next);
          library.current.value = library.cardAt(next)?.id ?? null;
          requestAnimationFrame(() => document.querySelector<HTMLElement>(`.card-list [data-row="${next}"]`)?.focus());
        }}
        render={(row) => {
          const card = library.cardAt(row);
          if (!card) return <div class="list-row waiting" role="row" data-row={row} aria-label={w("label.loading")} />;
          const isPicked = library.picked.value.has(card.id);
          return (
            <div
              class={`list-row ${isPicked ? "picked" : ""}`}
              role="row"
              data-row={row}
              tabIndex={row === focus ? 0 : -1}
              aria-selected={isPicked}
              aria-rowindex={row + 1}
              onFocus={() => {
                library.current.value = card.id;
                setFocus(row);
              }}
              onPointerEnter={() => (library.current.value = card.id)}
              onClick={(event) => {
                if (!pickBy(event, row, card.id)) go(`/clips/${card.id}`);
              }}
              onKeyDown={(event) => {
                if (event.key === "Enter") go(`/clips/${card.id}`);
              }}
            >
              <span role="gridcell">
                <ThumbnailView thumbnail={card.thumb} runs={library.current.value === card.id} label="" />
              </span>
              <strong role="gridcell" class="cut">
                {card.name}
              </strong>
              <span role="gridcell" class="cut">
                {card.project || "–"}
              </span>
              <span role="gridcell">{card.format}</span>
              <span role="gridcell" class="n">
                {duration(card.duration)} <span class="dim">{number(card.frames)}</span>
              </span>
              <span role="gridcell" class="n">
                {rate(card.seconds_per_frame)}
              </span>
              <span role="gridcell">
                <SpanStrip labels={card.labels} frames={card.frames || 1} />
              </span>
              <span role="gridcell" class="dim cut">
                {when(card.modified)}
              </span>
            </div>
          );
        }}
      />
    </div>
  );
}
