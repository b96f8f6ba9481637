/** Angular speed over time with the phases behind it; where it is asked for, their edges are dragged, or moved by keys. */
import { numberAt } from "../../lists";
import { effect } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Player } from "../../state/clip/player";
import { colour, look } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import { number } from "../../words";
import { LEAST_PHASE, type Times } from "./corrections";
import { b } from "./words";

export interface Curve {
  values: ArrayLike<number>;
  fps: number;
}

const PHASES = ["prepare", "reach", "settle"] as const;
const EDGES = ["t1", "t2", "end"] as const;
const [WIDE, HIGH] = [1000, 100];

export function PhaseChart({
  curve,
  times,
  seconds,
  most,
  behind,
  label,
  player,
  onMove,
  onEnd,
}: {
  curve: Curve;
  /** Frames from the first; null: none are known. */
  times: Times | null;
  /** The whole of the axis. */
  seconds: number;
  /** The greatest speed of the axis. */
  most: number;
  behind?: Curve[];
  label: string;
  player?: Player;
  onMove?: (which: keyof Times, frame: number) => void;
  onEnd?: () => void;
}) {
  const box = useRef<HTMLDivElement>(null);
  const path = useMemo(() => pathOf(curve, seconds, most), [curve, seconds, most]);
  const share = (frame: number) => `${Math.min(100, (frame / curve.fps / seconds) * 100)}%`;
  const frameAt = (event: PointerEvent) => {
    const bounds = box.current!.getBoundingClientRect();
    return ((event.clientX - bounds.left) / bounds.width) * seconds * curve.fps;
  };
  const bounds = times && ([0, times.t1, times.t2, times.end] as const);
  const ticks = Array.from({ length: Math.floor(seconds / 0.5 + 1e-6) + 1 }, (_, at) => at * 0.5);
  return (
    <div class="phase-chart">
      <div class="phase-axis n" aria-hidden="true">
        <span>{number(most, 1)}</span>
        <span>rad/s</span>
      </div>
      <div class="phase-area" ref={box} role={onMove ? "group" : "img"} aria-label={label}>
        {bounds &&
          PHASES.map((one, at) => (
            <span
              key={one}
              class={`phase-zone ${one}`}
              style={{
                left: share(numberAt(bounds, at)),
                width: share(numberAt(bounds, at + 1) - numberAt(bounds, at)),
              }}
            >
              <span class="cut">{b(`label.${one}`)}</span>
            </span>
          ))}
        {behind && <Behind curves={behind} seconds={seconds} most={most} />}
        <svg viewBox={`0 0 ${WIDE} ${HIGH}`} preserveAspectRatio="none" aria-hidden="true">
          <path d={path} />
        </svg>
        {player && <Cursor player={player} seconds={seconds} />}
        {times &&
          onMove &&
          EDGES.map((one) => (
            <span
              key={one}
              class="phase-edge"
              data-edge={one}
              role="slider"
              tabIndex={0}
              style={{ left: share(times[one]) }}
              aria-label={b(`label.${one}Edge`)}
              title={b(`label.${one}Edge`)}
              aria-valuemin={0}
              aria-valuemax={Math.round(seconds * curve.fps)}
              aria-valuenow={Math.round(times[one] * 10) / 10}
              aria-valuetext={b("label.edgeAt", {
                frames: number(times[one], 1),
                seconds: number(times[one] / curve.fps, 2),
              })}
              onPointerDown={(event) => {
                event.currentTarget.setPointerCapture(event.pointerId);
                event.preventDefault();
                event.currentTarget.focus();
                event.currentTarget.onpointermove = (move) => onMove(one, frameAt(move));
              }}
              onPointerUp={(event) => {
                event.currentTarget.onpointermove = null;
                onEnd?.();
              }}
              onKeyDown={(event) => {
                const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[
                  event.key
                ];
                if (!step) return;
                onMove(one, times[one] + step * (event.shiftKey ? 0.1 : LEAST_PHASE));
                onEnd?.();
                event.preventDefault();
                event.stopPropagation();
              }}
            >
              <span>{one === "end" ? b("label.endShort") : one}</span>
            </span>
          ))}
      </div>
      <div class="phase-ticks n" aria-hidden="true">
        {ticks.map((one) => (
          <span key={one} style={{ left: `${(one / seconds) * 100}%` }}>
            {number(one, 1)}
            {one ? "" : " s"}
          </span>
        ))}
      </div>
    </div>
  );
}

function pathOf({ values, fps }: Curve, seconds: number, most: number): string {
  let path = "";
  for (let frame = 0; frame < values.length; frame++) {
    path += `${frame ? "L" : "M"}${((frame / fps / seconds) * WIDE).toFixed(1)} ${(HIGH - Math.min(1.05, numberAt(values, frame) / most) * (HIGH - 6) - 2).toFixed(1)}`;
  }
  return path;
}

/** The examples' curves: drawn once, since there are many. */
function Behind({ curves, seconds, most }: { curves: Curve[]; seconds: number; most: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const element = canvas.current!;
    const draw = () => {
      const { pen, width, height } = penOf(element);
      pen.strokeStyle = colour("text3");
      pen.globalAlpha = 0.22;
      pen.lineWidth = 1;
      for (const { values, fps } of curves) {
        pen.beginPath();
        for (let frame = 0; frame < values.length; frame++)
          pen.lineTo(
            (frame / fps / seconds) * width,
            height - Math.min(1.05, numberAt(values, frame) / most) * height * 0.94 - height * 0.02,
          );
        pen.stroke();
      }
    };
    const observer = new ResizeObserver(draw);
    observer.observe(element);
    return () => observer.disconnect();
  }, [curves, seconds, most, look.value]);
  return <canvas ref={canvas} aria-hidden="true" />;
}

function Cursor({ player, seconds }: { player: Player; seconds: number }) {
  const line = useRef<HTMLSpanElement>(null);
  useEffect(
    () =>
      effect(() => {
        const at = player.frame.value / player.perSecond / seconds;
        if (line.current) line.current.style.left = `${Math.min(1, at) * 100}%`;
      }),
    [player, seconds],
  );
  return <span ref={line} class="phase-cursor" />;
}
