/** A measure of the body as a curve over the clip, with a threshold to pull. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { rounded } from "../../../motion/body/quantities";
import type { Clip } from "../../../state/clip/clip";
import { colour, look } from "../../../state/session/settings";
import { inSight } from "../timeline/Timeline";

const NEAR = 10;

export function Curve({
  clip,
  values,
  label,
  unit,
  limit,
  above,
  onLimit,
}: {
  clip: Clip;
  values: Float64Array;
  label: string;
  unit: string;
  limit: number | null;
  above: boolean;
  onLimit: (at: number) => void;
}) {
  const host = useRef<HTMLDivElement>(null);
  const playhead = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const now = useRef({ limit, above, onLimit });
  now.current = { limit, above, onLimit };
  useEffect(() => {
    const element = host.current!;
    const follow = (self: uPlot) => {
      if (playhead.current)
        playhead.current.style.transform = `translateX(${self.valToPos(clip.player.frame.peek() + 1, "x") + self.over.offsetLeft}px)`;
    };
    const grid = { stroke: colour("line"), width: 1 };
    const axis = {
      stroke: colour("text3"),
      grid,
      ticks: grid,
      font: `11px ${getComputedStyle(element).fontFamily}`,
      size: 52,
    };
    const made = new uPlot(
      {
        width: element.clientWidth,
        height: Math.max(160, element.clientHeight),
        legend: { show: false },
        scales: {
          x: {
            time: false,
            range: () => [inSight.peek().first + 1, Math.max(inSight.peek().first + 2, inSight.peek().last)],
          },
          y: {},
        },
        axes: [
          { ...axis, size: 26 },
          { ...axis, label: unit || undefined, labelSize: unit ? 16 : 0, labelFont: axis.font },
        ],
        cursor: { drag: { x: false, y: false }, points: { size: 7 } },
        series: [{}, { label, stroke: colour("accent"), width: 1.6, spanGaps: false }],
        hooks: {
          draw: [
            (self) => {
              follow(self);
              drawLimit(self, now.current.limit, now.current.above);
            },
          ],
        },
      },
      [
        Float64Array.from({ length: values.length }, (_, at) => at + 1),
        Array.from(values, (value) => (value === value ? value : null)),
      ] as never,
      element,
    );
    plot.current = made;
    const observer = new ResizeObserver(() =>
      made.setSize({ width: element.clientWidth, height: Math.max(160, element.clientHeight) }),
    );
    observer.observe(element);
    const stops = [
      effect(() => {
        const { first, last } = inSight.value;
        made.setScale("x", { min: first + 1, max: Math.max(first + 2, last) });
      }),
      effect(() => {
        clip.player.frame.value;
        follow(made);
      }),
    ];
    made.over.addEventListener("pointerdown", (event) => press(event, clip, made, now.current));
    return () => {
      for (const stop of stops) stop();
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [values, label, unit, look.value]);
  useEffect(() => plot.current?.redraw(false), [limit, above]);
  return (
    <div class="graph-plot" ref={host} role="img" aria-label={label}>
      <div ref={playhead} class="graph-playhead" />
    </div>
  );
}

/** Take hold of the threshold near the pointer, else go to the frame. */
function press(
  event: PointerEvent,
  clip: Clip,
  made: uPlot,
  now: { limit: number | null; onLimit: (at: number) => void },
): void {
  const box = made.over.getBoundingClientRect();
  if (event.button) return;
  if (now.limit === null || Math.abs(made.valToPos(now.limit, "y") - (event.clientY - box.top)) > NEAR) {
    clip.player.seek(
      Math.max(0, Math.min(clip.frames - 1, Math.round(made.posToVal(event.clientX - box.left, "x")) - 1)),
    );
    return;
  }
  event.preventDefault();
  const move = (moving: PointerEvent) => now.onLimit(rounded(made.posToVal(moving.clientY - box.top, "y")));
  const up = () => {
    removeEventListener("pointermove", move);
    removeEventListener("pointerup", up);
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", up);
}

/** The threshold, and the side of it that is asked for. */
function drawLimit(self: uPlot, limit: number | null, above: boolean): void {
  if (limit === null) return;
  const { ctx, bbox } = self;
  const y = Math.max(bbox.top, Math.min(bbox.top + bbox.height, self.valToPos(limit, "y", true)));
  ctx.save();
  ctx.fillStyle = colour("select");
  ctx.globalAlpha = 0.1;
  ctx.fillRect(bbox.left, above ? bbox.top : y, bbox.width, above ? y - bbox.top : bbox.top + bbox.height - y);
  ctx.globalAlpha = 1;
  ctx.strokeStyle = colour("select");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}
