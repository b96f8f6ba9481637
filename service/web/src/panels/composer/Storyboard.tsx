/** The pieces in their order, as wide as they last; below each the layers on it. Edges trim, the middle moves, seams are pressed. */
import { itemAt } from "../../lists";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { nameColour } from "../../motion/timeline/colours";
import { sizeOf, type Piece, type Stretch } from "../../state/editing/composition";
import { Icon } from "../../ui/icons";
import { number, w } from "../../words";
import { carried, type Board } from "./board";
import { facts } from "./facts";
import { LayerLane } from "./LayerLane";
import { isRough, type Composed } from "./seams";
import { edgeAt, follow, trimmed, type Trial } from "./trimming";

const USUAL_RATE = 30;
const CLICK = 4; // px that are no drag

/** Seconds that a piece lasts. */
const lasting = (piece: Piece) =>
  Math.max(1, sizeOf(piece)) / (facts.value.get(piece.document)?.perSecond ?? USUAL_RATE) / piece.speed;

export function Storyboard({ board, composed }: { board: Board; composed: Composed | null }) {
  const strip = useRef<HTMLDivElement>(null);
  const trial = useSignal<(Trial & { widths: number[] }) | null>(null);
  const moving = useSignal<{ key: number; pixels: number; to: number } | null>(null);
  const over = useSignal<number | null>(null);
  const pieces = board.pieces.value;
  const here = board.at.value;
  const whole = pieces.reduce((sum, one) => sum + lasting(one), 0) || 1;

  const take = (event: PointerEvent, index: number) => {
    if (event.button) return;
    const one = itemAt(pieces, index);
    board.chosen.value = { kind: "piece", key: one.key };
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const edge = edgeAt(event, box);
    const slots = [...strip.current!.querySelectorAll<HTMLElement>(".piece-slot")].map((slot) =>
      slot.getBoundingClientRect(),
    );
    const perPixel = sizeOf(one) / box.width;
    const spans = facts.peek().get(one.document)?.spans ?? [];
    follow(
      event,
      (pixels, move) => {
        if (edge && one.frames) {
          trial.value = {
            key: one.key,
            at: 1,
            edge,
            ...trimmed(one, edge, pixels, perPixel, spans, move.altKey),
            widths: slots.map((slot) => slot.width),
          };
        } else if (Math.abs(pixels) > CLICK) {
          const to = slots.findIndex((slot) => move.clientX < slot.left + slot.width / 2);
          moving.value = { key: one.key, pixels, to: to < 0 ? slots.length : to };
        }
      },
      (cancelled) => {
        const [cut, moved] = [trial.peek(), moving.peek()];
        trial.value = moving.value = null;
        if (cancelled) return;
        if (cut && (cut.first !== one.first || cut.last !== one.last))
          board.setPiece(one.key, { first: cut.first, last: cut.last });
        if (moved) board.moveTo(index, moved.to > index ? moved.to - 1 : moved.to);
      },
    );
  };
  const onDrop = (event: DragEvent, index: number) => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    over.value = null;
    board.add(carried(event), event.clientX > box.left + box.width / 2 ? index + 1 : index);
  };
  return (
    <div
      ref={strip}
      class="pieces"
      role="group"
      aria-label={w("label.pieces")}
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => board.add(carried(event))}
    >
      {pieces.map((each, index) => {
        const cut = trial.value?.key === each.key ? trial.value : null;
        const one = cut ? { ...each, first: cut.first, last: cut.last } : each;
        const moved = moving.value?.key === each.key ? moving.value : null;
        const shown = here?.piece.key === each.key;
        // While an edge is dragged nothing else moves: the edge stays under the pointer.
        const fixed = trial.value && trial.value.widths[index];
        const width = fixed ? `${fixed * (cut ? sizeOf(one) / Math.max(1, sizeOf(each)) : 1)}px` : undefined;
        const pushed =
          fixed && cut?.edge === "first"
            ? `${fixed * ((one.first - each.first) / Math.max(1, sizeOf(each)))}px`
            : undefined;
        return (
          <div
            key={each.key}
            class={`piece-slot ${moved ? "moved" : ""} ${moving.value?.to === index && !moved ? "before" : ""} ${over.value === index ? "over" : ""}`}
            style={{
              flex: width ? `0 0 ${width}` : `${lasting(each) / whole} 1 0`,
              minWidth: width ? "0" : undefined,
              marginLeft: pushed,
              transform: moved ? `translateX(${moved.pixels}px)` : undefined,
            }}
          >
            <div class="piece-row">
              {index > 0 && <Seam board={board} index={index} composed={composed} />}
              <button
                type="button"
                class="piece"
                aria-pressed={shown && here.kind === "piece"}
                tabIndex={shown ? 0 : -1}
                data-key={each.key}
                onPointerDown={(event) => take(event, index)}
                onClick={() => (board.chosen.value = { kind: "piece", key: each.key })}
                onDragOver={(event) => {
                  event.preventDefault();
                  over.value = index;
                }}
                onDragLeave={() => (over.value = null)}
                onDrop={(event) => onDrop(event, index)}
                onKeyDown={(event) => {
                  const to = { ArrowLeft: index - 1, ArrowRight: index + 1 }[event.key];
                  if (to === undefined || event.altKey || !pieces[to]) return;
                  board.chosen.value = { kind: "piece", key: pieces[to].key };
                  strip.current?.querySelector<HTMLElement>(`[data-key="${pieces[to].key}"]`)?.focus();
                  event.preventDefault();
                  event.stopPropagation();
                }}
              >
                <span class="unseen">{w("label.piece", { n: index + 1 })}: </span>
                <strong class="cut">{one.name || "…"}</strong>
                <span class="dim cut row">
                  {number(one.first)}–{number(one.last)}
                  {one.speed !== 1 && <span>× {number(one.speed, 2)}</span>}
                  {one.mirror && (
                    <>
                      <Icon name="mirror" />
                      <span class="unseen">{w("label.mirrored")}</span>
                    </>
                  )}
                </span>
                <Spans piece={one} />
                <Playhead board={board} index={index} />
              </button>
              {cut && (
                <span class={`edge-note ${cut.edge}`} role="status">
                  {number(one[cut.edge === "first" ? "first" : "last"])}
                  {cut.name && <strong> {cut.name}</strong>}
                </span>
              )}
            </div>
            <LayerLane board={board} piece={one} index={index} />
          </div>
        );
      })}
      {moving.value?.to === pieces.length && <span class="drop-end" />}
    </div>
  );
}

function Seam({ board, index, composed }: { board: Board; index: number; composed: Composed | null }) {
  const piece = itemAt(board.pieces.value, index);
  const trial = useSignal<number | null>(null);
  const made = composed?.seams.find((other) => other.segment === index + 1);
  const own = piece.transition ?? null;
  const length = trial.value ?? own ?? made?.transition ?? board.steps.now.value.transition ?? 0;
  const chosen = board.at.value?.kind === "seam" && board.at.value.index === index;
  const choose = () => (board.chosen.value = { kind: "seam", key: piece.key });
  return (
    <button
      type="button"
      class={`seam ${made && isRough(made) ? "rough" : ""} ${own !== null || piece.style ? "own" : ""}`}
      aria-pressed={chosen}
      aria-label={w("label.seamOf", { n: index, next: index + 1, frames: length })}
      title={w("help.seamHelp")}
      onClick={choose}
      onPointerDown={(event) => {
        if (event.button) return;
        const before = own ?? made?.transition ?? length;
        follow(
          event,
          (pixels) => {
            if (Math.abs(pixels) > CLICK) trial.value = Math.max(0, Math.round(before + pixels / 2));
          },
          (cancelled) => {
            if (!cancelled && trial.peek() !== null) board.setPiece(piece.key, { transition: trial.peek() });
            trial.value = null;
            choose();
          },
        );
      }}
      onKeyDown={(event) => {
        const step = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
        if (!step) return;
        board.setPiece(piece.key, { transition: Math.max(0, length + step) }, "seam");
        event.preventDefault();
        event.stopPropagation();
      }}
    >
      {made || trial.value !== null || own !== null ? number(length) : "…"}
    </button>
  );
}

/** The motion names of what is taken of the clip. */
export function Spans({ piece }: { piece: { document: string; first: number; last: number } }) {
  const spans: readonly Stretch[] = facts.value.get(piece.document)?.spans ?? [];
  const size = Math.max(1, sizeOf(piece));
  return (
    <span class="strip" aria-hidden="true">
      {spans
        .filter((one) => one.last >= piece.first && one.first <= piece.last)
        .map((one, index) => {
          const [first, last] = [Math.max(one.first, piece.first), Math.min(one.last, piece.last)];
          return (
            <span
              key={index}
              title={one.name}
              style={{
                left: `${((first - piece.first) / size) * 100}%`,
                width: `${((last - first + 1) / size) * 100}%`,
                background: nameColour(one.name),
              }}
            />
          );
        })}
    </span>
  );
}

function Playhead({ board, index }: { board: Board; index: number }) {
  const line = useRef<HTMLSpanElement>(null);
  useEffect(
    () =>
      board.place.subscribe((place) => {
        if (!line.current) return;
        line.current.hidden = place?.index !== index;
        if (place?.index === index) line.current.style.left = `${place.share * 100}%`;
      }),
    [index],
  );
  return <span ref={line} class="piece-playhead" hidden aria-hidden="true" />;
}
