import { useState } from "preact/hooks";
import { nameColour } from "../../motion/timeline/colours";
import * as library from "../../state/library/library";
import type { Card } from "../../state/library/library";
import { Icon } from "../../ui/icons";
import { MiddleCut } from "../../ui/MiddleCut";
import { ThumbnailView } from "../../ui/clips/ThumbnailView";
import { prefetch } from "../../state/session/prefetch";
import { duration, rate, w } from "../../words";
import { pickBy } from "./picking";

/** The strip of a clip's motion names. */
export function SpanStrip({
  labels,
  frames,
}: {
  labels: { name: string; first: number; last: number }[];
  frames: number;
}) {
  return (
    <div class="strip" aria-hidden="true">
      {labels.map((one, index) => (
        <span
          key={index}
          title={one.name}
          style={{
            left: `${((one.first - 1) / frames) * 100}%`,
            width: `${((one.last - one.first + 1) / frames) * 100}%`,
            background: nameColour(one.name),
          }}
        />
      ))}
    </div>
  );
}

export function CardView({
  card,
  row,
  runs,
  tabIndex,
  onFocus,
  onOpen,
}: {
  card: Card | null;
  row: number;
  runs: boolean;
  tabIndex: number;
  onFocus: () => void;
  onOpen: (card: Card) => void;
}) {
  const [scrub, setScrub] = useState<number | null>(null);
  if (!card)
    return (
      <div class="card waiting" role="gridcell" data-row={row} tabIndex={tabIndex} aria-label={w("label.loading")} />
    );
  const isPicked = library.picked.value.has(card.id);
  const names = [...new Set(card.labels.map((label) => label.name))];
  return (
    <div
      class={`card ${isPicked ? "picked" : ""} ${library.current.value === card.id ? "current" : ""}`}
      role="gridcell"
      data-row={row}
      data-id={card.id}
      tabIndex={tabIndex}
      aria-selected={isPicked}
      onFocus={() => {
        library.current.value = card.id;
        onFocus();
      }}
      onPointerEnter={() => {
        library.current.value = card.id;
        prefetch("clip");
      }}
      onPointerLeave={() => setScrub(null)}
      onPointerMove={(event) => {
        const box = event.currentTarget.getBoundingClientRect();
        if (event.pointerType === "mouse" && event.clientY - box.top < box.height * 0.72)
          setScrub(Math.max(0, Math.min(1, (event.clientX - box.left) / box.width)));
        else setScrub(null);
      }}
      onClick={(event) => {
        if (!pickBy(event, row, card.id)) onOpen(card);
      }}
      onKeyDown={(event) => {
        if (event.key === "Enter") onOpen(card);
        else if (event.key === " ") {
          library.pick(card.id);
          event.preventDefault();
          event.stopPropagation();
        }
      }}
    >
      <ThumbnailView thumbnail={card.thumb} runs={runs || library.current.value === card.id} scrub={scrub} label="" />
      <SpanStrip labels={card.labels} frames={card.frames || 1} />
      <div class="card-words">
        <strong>
          <MiddleCut text={card.name} />
        </strong>
        {names.length > 0 && <span class="unseen">{names.slice(0, 4).join(", ")}</span>}
        <span class="dim cut">
          {(card.duration === null || card.duration === undefined
            ? [w("label.frames", { n: card.frames }), card.format]
            : [duration(card.duration), rate(card.seconds_per_frame), card.format]
          ).join(" · ")}
        </span>
      </div>
      <button
        type="button"
        class="card-pick"
        tabIndex={-1}
        aria-label={w("button.pickClip", { name: card.name })}
        aria-pressed={isPicked}
        onClick={(event) => {
          event.stopPropagation();
          library.pick(card.id);
        }}
      >
        {isPicked && <Icon name="check" />}
      </button>
    </div>
  );
}
