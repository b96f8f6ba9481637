/** The speed of a clip with its beats, what was refused, and its bars: all of it can be pressed, dragged, and walked by keys. */
import { itemAt } from "../../lists";
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { nearestBeat, snapped } from "../../motion/dance/dancing";
import { colour, look } from "../../state/session/settings";
import { number } from "../../words";
import type { Bench } from "./bench";
import { drawLane, NEAR, type Dragged } from "./drawLane";
import type { Candidate, ClipRow } from "./rows";
import { d } from "./words";

const SECONDS_SEEN = 90; // of one row; longer clips scroll

export function ClipLane({ bench, row, index }: { bench: Bench; row: ClipRow; index: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const drag = useRef<(Dragged & { moved: boolean }) | null>(null);
  const [tip, setTip] = useState<{ x: number; text: string } | null>(null);
  const paint = useRef(() => undefined as void);
  const active = bench.clip.value === row.id;
  const beat = active ? bench.beat.value : -1;
  paint.current = () => {
    if (canvas.current)
      drawLane(canvas.current, row, {
        ink: colour(`name${index % 8}`),
        stale: bench.stale.peek().has(row.id),
        at: bench.clip.peek() === row.id ? bench.at.peek() : null,
        beat: bench.clip.peek() === row.id ? bench.beat.peek() : -1,
        drag: drag.current,
      });
  };
  useEffect(
    () =>
      effect(() => {
        bench.at.value;
        bench.beat.value;
        bench.clip.value;
        bench.stale.value;
        look.value;
        paint.current();
      }),
    [row],
  );
  useEffect(() => {
    const observer = new ResizeObserver(() => paint.current());
    observer.observe(canvas.current!);
    return () => observer.disconnect();
  }, []);
  const perPixel = () => row.seconds / Math.max(1, canvas.current!.clientWidth);
  const at = (event: MouseEvent) =>
    Math.max(0, Math.min(row.seconds, (event.clientX - canvas.current!.getBoundingClientRect().left) * perPixel()));
  const down = (event: PointerEvent) => {
    if (event.button) return;
    const here = at(event);
    const found = nearestBeat(row.beats, here, NEAR * perPixel());
    canvas.current!.setPointerCapture(event.pointerId);
    bench.clip.value = row.id;
    bench.beat.value = found;
    if (found >= 0) drag.current = { index: found, at: itemAt(row.beats, found).at, moved: false };
    else bench.go(row.id, here);
  };
  const move = (event: PointerEvent) => {
    const here = at(event);
    const held = drag.current;
    if (!held) {
      setTip(tipOf(row, here, NEAR * perPixel(), event, canvas.current!));
      return;
    }
    if (!held.moved && Math.abs(here - held.at) < 3 * perPixel()) return;
    held.moved = true;
    held.at = event.altKey ? here : snapped(here, row.minima, NEAR * perPixel());
    setTip({ x: event.clientX - canvas.current!.getBoundingClientRect().left, text: `${number(held.at, 3)} s` });
    paint.current();
  };
  const up = () => {
    const held = drag.current;
    drag.current = null;
    if (!held) return;
    if (held.moved) bench.moveBeat(row.id, held.index, held.at);
    else bench.go(row.id, held.at);
    paint.current();
  };
  const key = (event: KeyboardEvent) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const last = row.beats.length - 1;
    const now = bench.clip.peek() === row.id ? bench.beat.peek() : -1;
    if (by && event.altKey && now >= 0) {
      const to = itemAt(row.beats, now).at + by / row.fps;
      bench.moveBeat(row.id, now, to);
      bench.beat.value = nearestBeat(bench.row(row.id)!.beats, to, 1e-3);
    } else if (by || event.key === "Home" || event.key === "End") {
      const next =
        event.key === "Home" ? 0 : event.key === "End" ? last : Math.max(0, Math.min(last, now < 0 ? 0 : now + by!));
      bench.beat.value = next;
      if (row.beats[next]) bench.go(row.id, row.beats[next].at);
      bench.beat.value = next;
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };
  const option = (one: number) => `beat-${row.id}-${one}`;
  return (
    <div
      class={`lane ${active ? "active" : ""}`}
      role="listbox"
      tabIndex={0}
      aria-label={d("label.rowOf", { name: row.name })}
      aria-activedescendant={beat >= 0 && row.beats[beat] ? option(beat) : undefined}
      onKeyDown={key}
      onFocus={() => {
        if (bench.clip.peek() !== row.id) {
          bench.clip.value = row.id;
          bench.beat.value = -1;
        }
      }}
    >
      <canvas
        ref={canvas}
        aria-hidden="true"
        style={row.seconds > SECONDS_SEEN ? { width: `${Math.min(16_000, row.seconds * 12)}px` } : undefined}
        onPointerDown={down}
        onPointerMove={move}
        onPointerUp={up}
        onPointerLeave={() => setTip(null)}
        onDblClick={(event) => {
          if (nearestBeat(row.beats, at(event), NEAR * perPixel()) < 0)
            bench.addBeat(row.id, event.altKey ? at(event) : snapped(at(event), row.minima, NEAR * perPixel()));
        }}
      />
      {tip && (
        <span class="lane-tip" style={{ left: `${tip.x}px` }}>
          {tip.text}
        </span>
      )}
      {row.beats.map((one, place) => (
        <span key={place} class="unseen" role="option" id={option(place)} aria-selected={place === beat}>
          {d("label.beatOf", { n: place + 1, at: number(one.at, 3), kind: d(`label.${one.kind}`) })}
        </span>
      ))}
      {!row.beats.length && (
        <span class="unseen" role="option" aria-selected="false">
          {d("label.beatsOf", { n: 0 })}
        </span>
      )}
    </div>
  );
}

/** Why a minimum is no beat. */
export function reasonOf(one: Candidate): string {
  if (one.verdict === "F2") return d("label.F2", { dip: number(one.dip, 2), least: number(2 / 15, 2) });
  if (one.verdict === "F3") return d("label.F3", { rest: number(one.rest, 2), most: 1 });
  return d(`label.${one.verdict}`);
}

function tipOf(
  row: ClipRow,
  here: number,
  within: number,
  event: PointerEvent,
  canvas: HTMLElement,
): { x: number; text: string } | null {
  const x = event.clientX - canvas.getBoundingClientRect().left;
  const beat = nearestBeat(row.beats, here, within);
  if (beat >= 0)
    return {
      x,
      text: d("label.beatOf", {
        n: beat + 1,
        at: number(itemAt(row.beats, beat).at, 3),
        kind: d(`label.${itemAt(row.beats, beat).kind}`),
      }),
    };
  const near = row.candidates
    .filter((one) => one.verdict !== "beat" && Math.abs(one.at - here) <= within)
    .sort((a, b) => Math.abs(a.at - here) - Math.abs(b.at - here))[0];
  return near ? { x, text: `${number(near.at, 2)} s · ${reasonOf(near)}` } : null;
}
