/**
 * Ruler, names and speed over time. Spans are drawn, dragged, trimmed and split; each also is a button in the lane, so
 * that keys reach it.
 */
import { numberAt } from "../../../lists";
import { effect, signal, useSignal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import type { Span } from "../../../state/editing/draft";
import { colour, look, timeAs } from "../../../state/session/settings";
import { lanes, moved, rulerStep, toFrame, toX, zoomed, type Range } from "../../../motion/timeline/timeline";
import { nearestMark, stills } from "../../../motion/timeline/snapping";
import { speedOf } from "../../../motion/timeline/speed";
import { nameColour } from "../../../motion/timeline/colours";
import { timelineTall } from "../../../state/session/panes";
import { w } from "../../../words";
import { naming, newSpan } from "../actions";
import { clock } from "../../../motion/timeline/clock";
import { NameSpan } from "./NameSpan";
import { drawReplaced, ReplacedName } from "./replacedMarks";
import { newSuggestions, Suggestions, suggested } from "./Suggestions";

const RULER = 24;
const LANE = 24;
const EDGE = 6; // px of a span's end that trim it
const SHORTEST_DRAG = 4;
const SNAP = 6; // px
const HEAD = 64; // px of lane names

/** What is in sight; shared with the graph when the dock is below. */
export const inSight = signal<Range>({ first: 0, last: 1 });

export function Timeline({ clip }: { clip: Clip }) {
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [wide, setWide] = useState(600);
  const [tall, setTall] = useState(timelineTall.peek());
  /** The edge that was snapped to; null: none. */
  const snapLine = useSignal<number | null>(null);
  const drag = useSignal<{ span: Span; fresh: boolean } | null>(null);
  const { player, frames } = clip;

  useEffect(() => {
    inSight.value = { first: 0, last: Math.max(1, frames) };
    const observer = new ResizeObserver(([entry]) => {
      if (!entry) return;
      setWide(Math.max(100, entry.contentRect.width - HEAD));
      setTall(entry.contentRect.height);
    });
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, [clip]);

  const spans = clip.labels.value;
  const shownSpans = drag.value ? [...spans.filter((one) => one.id !== drag.value!.span.id), drag.value.span] : spans;
  const offered = newSuggestions(suggested.value, spans);
  const all = [...shownSpans, ...offered.map((one, index) => ({ ...one, id: -1e9 - index }))];
  const places = lanes(all);
  // One lane is free: a label is drawn there over any other.
  const laneCount = Math.max(0, ...places.map((lane) => lane + 1)) + 1;
  const range = inSight.value;

  // Ruler, loop, playhead and speed are drawn; they change with each frame.
  useEffect(
    () =>
      effect(() => {
        const element = canvas.current;
        if (!element) return;
        look.value;
        clip.blocks.arrived.value;
        drawRuler(element, clip, inSight.value, wide, tall, Math.min(laneCount, 6));
      }),
    [clip, wide, tall, laneCount],
  );

  const frameAt = (event: PointerEvent | WheelEvent): number => {
    const left = box.current!.getBoundingClientRect().left + HEAD;
    return Math.max(0, Math.min(frames - 1, Math.floor(toFrame(event.clientX - left, inSight.peek(), wide))));
  };
  const scrub = (event: PointerEvent) => {
    const playing = player.playing.peek();
    const element = event.currentTarget as HTMLElement;
    element.setPointerCapture(event.pointerId);
    player.pause();
    player.seek(frameAt(event));
    element.onpointermove = (move) => player.seek(frameAt(move));
    element.onpointerup = () => {
      element.onpointermove = element.onpointerup = null;
      if (playing) player.play();
    };
  };
  const onWheel = (event: WheelEvent) => {
    event.preventDefault();
    if (event.ctrlKey || event.metaKey || (!event.shiftKey && Math.abs(event.deltaY) > Math.abs(event.deltaX)))
      inSight.value = zoomed(inSight.peek(), frameAt(event), Math.exp(event.deltaY / 400), frames);
    else
      inSight.value = moved(
        inSight.peek(),
        ((event.deltaX || event.deltaY) / wide) * (range.last - range.first),
        frames,
      );
  };
  useEffect(() => {
    const element = box.current!;
    element.addEventListener("wheel", onWheel, { passive: false });
    return () => element.removeEventListener("wheel", onWheel);
  });

  /** An edge where it snaps, within a few pixels of a mark; Alt lets it be anywhere. */
  const snap = (edge: number, side: "first" | "last", own: number | null, event: PointerEvent): number => {
    const found = event.altKey
      ? null
      : nearestMark(edge, marksOf(clip, side, own), (SNAP * (range.last - range.first)) / wide);
    snapLine.value = found;
    return found ?? edge;
  };

  /** Draw a new span on the empty lane, or with Shift over one that is there. */
  const draw = (event: PointerEvent) => {
    if (event.button || (event.target !== event.currentTarget && !event.shiftKey)) return;
    const element = event.currentTarget as HTMLElement;
    element.setPointerCapture(event.pointerId);
    const [from, x0] = [frameAt(event), event.clientX];
    const begun = { first: snap(from, "first", null, event), last: snap(from + 1, "last", null, event) };
    snapLine.value = null;
    element.onpointermove = (move) => {
      if (clip.pinned !== null || Math.abs(move.clientX - x0) < SHORTEST_DRAG) return;
      const to = frameAt(move);
      const first = to < from ? Math.min(begun.last - 1, snap(to, "first", null, move)) : begun.first;
      const last = to < from ? begun.last : Math.max(begun.first + 1, snap(to + 1, "last", null, move));
      drag.value = { span: newSpan("", first + 1, last), fresh: true };
    };
    element.onpointerup = () => {
      element.onpointermove = element.onpointerup = null;
      if (drag.value) naming.value = { ...drag.value };
      else {
        player.pause();
        player.seek(from);
        clip.select([]);
      }
      drag.value = snapLine.value = null;
    };
  };

  /** Move a span, or trim the end that was taken. */
  const take = (event: PointerEvent, span: Span) => {
    if (event.button || clip.pinned !== null || event.shiftKey) return;
    event.stopPropagation();
    const element = event.currentTarget as HTMLElement;
    const bounds = element.getBoundingClientRect();
    const edge = event.clientX - bounds.left < EDGE ? "first" : bounds.right - event.clientX < EDGE ? "last" : "both";
    element.setPointerCapture(event.pointerId);
    const from = frameAt(event);
    let changed: Span | null = null;
    element.onpointermove = (move) => {
      const by = frameAt(move) - from;
      const next = { ...span };
      if (edge === "first") next.first = snap(span.first - 1 + by, "first", span.id, move) + 1;
      if (edge === "last") next.last = snap(span.last + by, "last", span.id, move);
      if (edge === "both") {
        const last = snap(span.last + by, "last", span.id, move) - span.last;
        const line = snapLine.peek();
        const first = snap(span.first - 1 + by, "first", span.id, move) - span.first + 1;
        const byLast = line !== null && (snapLine.peek() === null || Math.abs(last - by) < Math.abs(first - by));
        if (byLast) snapLine.value = line;
        const kept = Math.max(1 - span.first, Math.min(frames - span.last, byLast ? last : first));
        next.first = span.first + kept;
        next.last = span.last + kept;
      }
      next.first = Math.max(1, Math.min(next.first, edge === "first" ? span.last : next.first));
      next.last = Math.min(frames, Math.max(next.last, edge === "last" ? span.first : next.last));
      changed = next;
      drag.value = { span: next, fresh: false };
    };
    element.onpointerup = () => {
      element.onpointermove = element.onpointerup = null;
      drag.value = snapLine.value = null;
      if (changed && (changed.first !== span.first || changed.last !== span.last))
        clip.setLabels(spans.map((one) => (one.id === span.id ? changed! : one)));
    };
  };

  const key = (event: KeyboardEvent, span: Span) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step) {
      const next = { ...span };
      if (!event.shiftKey || event.altKey) next.first = Math.max(1, Math.min(span.last, span.first + step));
      if (event.shiftKey || event.altKey) next.last = Math.min(frames, Math.max(span.first, span.last + step));
      clip.setLabels(spans.map((one) => (one.id === span.id ? next : one)));
    } else if (event.key === "Delete") clip.setLabels(spans.filter((one) => one.id !== span.id));
    else if (event.key === "F2") naming.value = { span, fresh: false };
    else return;
    event.preventDefault();
    event.stopPropagation();
  };

  return (
    <section class="timeline" ref={box} aria-label={w("label.timeline")} style={{ height: `${timelineTall.value}px` }}>
      <canvas
        ref={canvas}
        class="timeline-canvas"
        style={{ left: `${HEAD}px`, width: `${wide}px` }}
        onPointerDown={scrub}
        aria-hidden="true"
      />
      <ReplacedName clip={clip} />
      <span class="lane-name" style={{ top: `${RULER + 6}px` }}>
        {w("label.namesLane")}
      </span>
      <span class="lane-name" style={{ top: `${RULER + Math.min(laneCount, 6) * LANE + 14}px` }}>
        {w("label.speedLane")}
      </span>
      <div
        class="spans"
        role="list"
        aria-label={w("label.names")}
        title={w("help.spanHelp")}
        style={{ left: `${HEAD}px`, top: `${RULER + 2}px`, height: `${Math.min(laneCount, 6) * LANE}px` }}
        onPointerDown={draw}
      >
        {all.map((span, index) => {
          const left = toX(span.first - 1, range, wide);
          const right = toX(span.last, range, wide);
          if (right < 0 || left > wide) return null;
          const isOffer = "confidence" in span;
          const style = {
            left: `${left}px`,
            width: `${Math.max(3, right - left - 1)}px`,
            top: `${numberAt(places, index) * LANE}px`,
            "--ink": nameColour(span.name),
          } as Record<string, string>;
          return isOffer ? (
            <Suggestions.Chip key={`?${span.name}${span.first}`} span={span as never} style={style} clip={clip} />
          ) : (
            <div key={span.id} role="listitem" class="span-item" style={style}>
              <button
                type="button"
                class="span"
                data-side={span.name.startsWith("left-") ? "left" : span.name.startsWith("right-") ? "right" : ""}
                aria-label={`${span.name || "…"}, ${span.first}–${span.last}`}
                title={`${span.name} ${span.first}–${span.last}`}
                onPointerDown={(event) => take(event, span)}
                onDblClick={() => (naming.value = { span, fresh: false })}
                onKeyDown={(event) => key(event, span)}
              >
                {span.name || "…"}
              </button>
            </div>
          );
        })}
      </div>
      {snapLine.value !== null && (
        <span class="snap-line" style={{ left: `${HEAD + toX(snapLine.value, range, wide)}px` }} />
      )}
      {naming.value && (
        <NameSpan
          key={naming.value.span.id}
          clip={clip}
          left={HEAD + Math.max(0, Math.min(wide - 350, toX(naming.value.span.first - 1, range, wide)))}
        />
      )}
    </section>
  );
}

/** What an edge snaps to: the playhead (a span's last frame may be the one that is shown), the loop, edges of other spans,
 * and where the body is slowest. */
function marksOf(clip: Clip, side: "first" | "last", own: number | null): number[] {
  const { player } = clip;
  const loop = player.loop.peek();
  const overview = clip.blocks.overview();
  return [
    player.frame.peek() + Number(side === "last"),
    ...(loop ? [loop[0], loop[1] + 1] : []),
    ...clip.labels
      .peek()
      .filter((span) => span.id !== own)
      .flatMap((span) => [span.first - 1, span.last]),
    ...(overview
      ? stills(speedOf(clip.blocks, overview.values, clip.skeleton.points), overview.step, player.perSecond)
      : []),
  ];
}

function drawRuler(
  element: HTMLCanvasElement,
  clip: Clip,
  range: Range,
  width: number,
  height: number,
  laneCount: number,
): void {
  const ratio = Math.min(devicePixelRatio, 2);
  if (element.width !== Math.round(width * ratio) || element.height !== Math.round(height * ratio)) {
    element.width = Math.round(width * ratio);
    element.height = Math.round(height * ratio);
    element.style.height = `${height}px`;
  }
  const pen = element.getContext("2d")!;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  const { player } = clip;
  const loop = player.loop.value;
  if (loop) {
    pen.fillStyle = `color-mix(in srgb, ${colour("accent")} 14%, transparent)`;
    const [from, to] = [toX(loop[0], range, width), toX(loop[1] + 1, range, width)];
    pen.fillRect(from, 0, to - from, height);
  }
  const step = rulerStep(range, width, 76);
  pen.strokeStyle = colour("line");
  pen.fillStyle = colour("text3");
  pen.beginPath();
  const fine = step >= 5 ? step / 5 : step;
  for (let frame = Math.ceil(range.first / fine) * fine; frame <= range.last; frame += fine) {
    const x = Math.round(toX(frame, range, width)) + 0.5;
    const major = frame % step === 0;
    pen.moveTo(x, major ? 10 : 16);
    pen.lineTo(x, RULER);
    if (major) {
      const text =
        timeAs.value === "frame" ? String(frame + 1) : clock(frame, player.perSecond, timeAs.value === "timecode");
      if (x + 4 + pen.measureText(text).width < width) pen.fillText(text, x + 4, 14);
    }
  }
  pen.moveTo(0, RULER + 0.5);
  pen.lineTo(width, RULER + 0.5);
  pen.stroke();
  drawReplaced(pen, clip, range, width, RULER);
  drawSpeed(pen, clip, range, width, RULER + laneCount * LANE + 8, height - 6);
  const x = Math.round(toX(player.frame.value + 0.5, range, width)) + 0.5;
  pen.strokeStyle = pen.fillStyle = colour("accent");
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(x, 0);
  pen.lineTo(x, height);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(x - 6, 0);
  pen.lineTo(x + 6, 0);
  pen.lineTo(x, 8);
  pen.fill();
  pen.lineWidth = 1;
}

/** How fast the body moves, from the coarse pass. */
function drawSpeed(
  pen: CanvasRenderingContext2D,
  clip: Clip,
  range: Range,
  width: number,
  top: number,
  bottom: number,
): void {
  const overview = clip.blocks.overview();
  if (!overview || bottom - top < 12) return;
  const { values, step } = overview;
  const speeds = speedOf(clip.blocks, values, clip.skeleton.points);
  let most = 0;
  for (const one of speeds) if (one > most) most = one;
  if (!most) return;
  pen.strokeStyle = colour("text3");
  pen.beginPath();
  let begun = false;
  const each = Math.max(1, Math.floor(((range.last - range.first) / step / width) * 0.5));
  for (
    let place = Math.max(0, Math.floor(range.first / step) - 1);
    place < speeds.length && place * step <= range.last + step;
    place += each
  ) {
    let value = 0;
    for (let at = place; at < Math.min(speeds.length, place + each); at++)
      value = Math.max(value, numberAt(speeds, at));
    const x = toX((place + 0.5) * step, range, width);
    const y = bottom - Math.sqrt(value / most) * (bottom - top);
    if (begun) pen.lineTo(x, y);
    else pen.moveTo(x, y);
    begun = true;
  }
  pen.stroke();
}
