/** Channels of the selected joint over time. Points are dragged; stretches are smoothed, scaled and shifted. */
import { itemAt, numberAt } from "../../../lists";
import { effect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { curvesOf } from "../../../motion/loading/blocks";
import { scaled, shifted, smoothed, unwrapped } from "../../../motion/timeline/curves";
import { localRotation } from "../../../motion/body/kinematics";
import type { Clip } from "../../../state/clip/clip";
import { orReplaced, withSamples, type Draft } from "../../../state/editing/draft";
import { colour, look } from "../../../state/session/settings";
import { Trouble } from "../../../ui/Trouble";
import { useAsync } from "../../../ui/useAsync";
import { number, w } from "../../../words";
import { FramesMenu } from "./FramesMenu";
import { inSight } from "./Timeline";

const NEAR = 9; // px from a curve that take hold of it
const AXIS_OF: Record<string, string> = { x: "x", y: "y", z: "z", w: "text2" };

export function Graph({ clip, reload }: { clip: Clip; reload: () => void }) {
  const name = clip.selection.value.bones[0];
  const index = name === undefined ? -1 : (clip.skeleton.byName.get(name) ?? -1);
  if (index < 0) return <div class="empty">{w("help.selectJoint")}</div>;
  return <BoneGraph key={name} clip={clip} bone={index} reload={reload} />;
}

function BoneGraph({ clip, bone, reload }: { clip: Clip; bone: number; reload: () => void }) {
  const joint = itemAt(clip.skeleton.view.bones, bone);
  const [kind, setKind] = useState<"R" | "T" | "Q">(joint.channels.some((one) => one[0] === "R") ? "R" : "T");
  const [hidden, setHidden] = useState<ReadonlySet<string>>(new Set());
  const [range, setRange] = useState<[number, number] | null>(null);
  const host = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const playhead = useRef<HTMLDivElement>(null);
  const stored = useAsync(
    (signal) => curvesOf(clip.id, clip.detail.revision, joint.name, signal),
    [clip.id, clip.detail.revision, joint.name],
    [clip],
  );
  const channels = joint.channels;
  const draft = clip.draft.value;

  const curves = useMemo(() => {
    const values = stored.value;
    if (!values) return null;
    const found = new Map<string, Float64Array>();
    channels.forEach((channel, column) => {
      const curve = new Float64Array(clip.frames);
      for (let frame = 0; frame < clip.frames; frame++)
        curve[frame] = numberAt(values, frame * channels.length + column);
      for (const [frame, value] of draft.samples.get(`${joint.name}.${channel}`) ?? []) curve[frame - 1] = value;
      found.set(channel, curve);
    });
    return found;
  }, [stored.value, draft]);

  const series = useMemo(() => {
    if (!curves) return [];
    if (kind === "Q") {
      const parts = ["x", "y", "z", "w"].map((axis) => ({ name: axis, axis, values: new Float64Array(clip.frames) }));
      for (let frame = 0; frame < clip.frames; frame++) {
        const turn = localRotation(
          joint,
          (channel) => curves.get(channel)?.[frame] ?? null,
          clip.skeleton.view.radians,
        );
        parts.forEach((part, place) => (part.values[frame] = numberAt(turn, place)));
      }
      return parts;
    }
    return channels
      .filter((channel) => channel[0] === kind || (kind === "T" && (channel === "SF" || channel === "weight")))
      .map((channel) => {
        const curve = curves.get(channel)!;
        const turn = Math.round((Math.PI * 2) / clip.skeleton.view.radians);
        return {
          name: channel,
          axis: channel[1]?.toLowerCase(),
          values: kind === "R" ? unwrapped(curve, turn) : curve,
        };
      });
  }, [curves, kind]);
  const visible = series.filter((one) => !hidden.has(one.name));

  useEffect(() => {
    const element = host.current;
    if (!element || !series.length) return;
    const frames = Float64Array.from({ length: clip.frames }, (_, at) => at + 1);
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
      size: 44,
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
        axes: [{ ...axis, size: 26 }, axis],
        cursor: { drag: { x: true, y: false, setScale: false }, points: { size: 7 } },
        series: [
          {},
          ...series.map((one) => ({
            label: one.name,
            stroke: colour((one.axis && AXIS_OF[one.axis]) ?? "text2"),
            width: 1.6,
            show: !hidden.has(one.name),
            dash: one.name === "w" ? [4, 3] : undefined,
          })),
        ],
        hooks: {
          draw: [(self) => follow(self)],
          setSelect: [
            (self) => {
              if (self.select.width > 2)
                setRange([
                  Math.max(1, Math.round(self.posToVal(self.select.left, "x"))),
                  Math.min(clip.frames, Math.round(self.posToVal(self.select.left + self.select.width, "x"))),
                ]);
              else setRange(null);
            },
          ],
        },
      },
      [frames, ...series.map((one) => one.values)] as never,
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
    const down = (event: PointerEvent) =>
      grab(
        event,
        clip,
        joint.name,
        made,
        series.map((one, place) => ({ ...one, place })),
        hidden,
        kind,
      );
    made.over.addEventListener("pointerdown", down, true);
    return () => {
      for (const stop of stops) stop();
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [series.length, kind, hidden, look.value, stored.value]);
  useEffect(() => {
    const made = plot.current;
    if (made && series.length) made.setData([made.data[0], ...series.map((one) => one.values)] as never);
  }, [series]);

  const apply = (tool: (values: Float64Array) => Float64Array) => {
    const [first, last] = range ?? [1, clip.frames];
    clip.attempt(() => {
      let next: Draft = clip.draft.peek();
      for (const one of visible) {
        const changed = tool(one.values.slice(first - 1, last));
        next = withSamples(
          next,
          `${joint.name}.${one.name}`,
          [...changed]
            .map((value, at): [number, number] => [first + at, rounded(value)])
            .filter(([, value]) => value === value),
        );
      }
      return { ...next, steps: clip.draft.peek().steps + 1 };
    });
  };
  return (
    <div class="graph">
      <div class="row graph-tools">
        <strong class="cut">{joint.name}</strong>
        <div class="segments" role="group" aria-label={w("label.channel")}>
          {channels.some((one) => one[0] === "R") && (
            <button type="button" aria-pressed={kind === "R"} onClick={() => setKind("R")}>
              {w("label.euler")}
            </button>
          )}
          {channels.some((one) => one[0] === "R") && (
            <button type="button" aria-pressed={kind === "Q"} onClick={() => setKind("Q")}>
              {w("label.quaternion")}
            </button>
          )}
          {channels.some((one) => one[0] === "T") && (
            <button type="button" aria-pressed={kind === "T"} onClick={() => setKind("T")}>
              {w("label.offset")}
            </button>
          )}
        </div>
        {series.map((one) => (
          <button
            key={one.name}
            type="button"
            class="chip"
            aria-pressed={!hidden.has(one.name)}
            onClick={() => {
              const next = new Set(hidden);
              if (!next.delete(one.name)) next.add(one.name);
              setHidden(next);
            }}
          >
            <span
              class="swatch"
              style={{
                background: hidden.has(one.name)
                  ? "transparent"
                  : `var(--${(one.axis && AXIS_OF[one.axis]) ?? "text2"})`,
                outline: "1px solid var(--edge)",
              }}
            />
            {one.name}
          </button>
        ))}
      </div>
      <Trouble error={stored.error} retry={stored.again} />
      {stored.busy && !stored.value && <div class="busy" />}
      <div
        class="graph-plot"
        ref={host}
        role="img"
        aria-label={`${joint.name}: ${series.map((one) => one.name).join(", ")}`}
      >
        <div ref={playhead} class="graph-playhead" />
      </div>
      {kind !== "Q" && clip.pinned === null && (
        <Tools apply={apply} range={range}>
          <FramesMenu clip={clip} range={range} reload={reload} />
        </Tools>
      )}
      {kind !== "Q" && clip.pinned === null && (
        <Keys clip={clip} bone={joint.name} channels={series.map((one) => one.name)} />
      )}
    </div>
  );
}

const rounded = (value: number): number => Number(value.toFixed(6));

/** Take hold of a curve near the pointer and drag its sample up and down. */
function grab(
  event: PointerEvent,
  clip: Clip,
  bone: string,
  made: uPlot,
  series: { name: string; values: Float64Array; place: number }[],
  hidden: ReadonlySet<string>,
  kind: string,
): void {
  if (kind === "Q" || clip.pinned !== null || event.button) return;
  const box = made.over.getBoundingClientRect();
  const frame = Math.max(1, Math.min(clip.frames, Math.round(made.posToVal(event.clientX - box.left, "x"))));
  const y = event.clientY - box.top;
  const near = series
    .filter((one) => !hidden.has(one.name))
    .map((one) => ({ one, away: Math.abs(made.valToPos(numberAt(one.values, frame - 1), "y") - y) }))
    .sort((a, b) => a.away - b.away)[0];
  if (!near || near.away > NEAR) return;
  event.stopPropagation();
  event.preventDefault();
  clip.player.pause();
  clip.player.seek(frame - 1);
  const track = `${bone}.${near.one.name}`;
  const before = clip.draft.peek();
  const [from, start] = [made.posToVal(y, "y"), numberAt(near.one.values, frame - 1)];
  let begun = false;
  const move = (moving: PointerEvent) => {
    const value = rounded(start + made.posToVal(moving.clientY - box.top, "y") - from);
    const next = orReplaced(() => withSamples(before, track, [[frame, value]]));
    if (!next) return;
    if (begun) clip.amend(next);
    else clip.change(next);
    begun = true;
  };
  const up = () => {
    removeEventListener("pointermove", move);
    removeEventListener("pointerup", up);
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", up);
}

function Tools({
  apply,
  range,
  children,
}: {
  apply: (tool: (values: Float64Array) => Float64Array) => void;
  range: [number, number] | null;
  children: ComponentChildren;
}) {
  const [width, setWidth] = useState(4);
  const [factor, setFactor] = useState(1.1);
  const [by, setBy] = useState(5);
  const tool = (label: string, value: number, set: (value: number) => void, step: number, run: () => void) => (
    <span class="row">
      <input
        class="field number"
        type="number"
        aria-label={label}
        value={value}
        step={step}
        onInput={(event) => set(Number(event.currentTarget.value))}
      />
      <button type="button" class="button dense" onClick={run}>
        {label}
      </button>
    </span>
  );
  return (
    <div class="curve-tools" role="group" aria-label={w("label.curveTools")}>
      <span class="row">
        <span class="dim">
          {range ? w("label.overRange", { first: range[0], last: range[1] }) : w("help.selectFrames")}
        </span>
        {range && children}
      </span>
      <span class="row wrap">
        {tool(w("label.smooth"), width, setWidth, 1, () => apply((values) => smoothed(values, Math.max(0.5, width))))}
        {tool(w("label.scale"), factor, setFactor, 0.05, () => apply((values) => scaled(values, factor)))}
        {tool(w("label.offset"), by, setBy, 1, () => apply((values) => shifted(values, by)))}
      </span>
    </div>
  );
}

/** The samples at the playhead as numbers: what every drag also can be. */
function Keys({ clip, bone, channels }: { clip: Clip; bone: string; channels: string[] }) {
  const frame = clip.player.playing.value ? clip.player.frame.peek() : clip.player.frame.value;
  void clip.channels.arrived.value;
  void clip.draft.value;
  useEffect(() => {
    if (!clip.player.playing.peek()) clip.channels.want(frame);
  }, [frame]);
  return (
    <div class="keys-now row wrap" role="group" aria-label={w("label.setKey", { frame: frame + 1 })}>
      <span class="dim">{w("label.setKey", { frame: number(frame + 1) })}</span>
      {channels.map((channel) => {
        const value = clip.sample(`${bone}.${channel}`, frame);
        return (
          <label key={channel} class="row">
            <span class="dim">{channel}</span>
            <input
              class="field number"
              type="number"
              step="any"
              value={value === null || Number.isNaN(value) ? "" : value}
              onChange={(event) => {
                const next = Number(event.currentTarget.value);
                if (event.currentTarget.value !== "" && Number.isFinite(next))
                  clip.setSamples(`${bone}.${channel}`, [[frame + 1, next]]);
              }}
            />
          </label>
        );
      })}
    </div>
  );
}
