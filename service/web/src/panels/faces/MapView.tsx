/** The map: all frames on the graphics card; over them candidates, links, the path, and where the animation is. */
import { numberAt } from "../../lists";
import { effect, type ReadonlySignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Grid } from "../../motion/faces/grid";
import { Cloud, type View } from "../../scene/cloud";
import { colour, look } from "../../state/session/settings";
import { Icon } from "../../ui/icons";
import { f } from "./words";
import { MOST_LINKS, type Level, type Space } from "./space";

export interface OnMap {
  level: Level;
  /** Frames, in the order of the path. */
  keys: number[];
  /** Frames of the walk where the path is made. */
  walk: ArrayLike<number>;
  /** A way that is offered, as frames. */
  route: number[];
  offers: number[];
  /** The candidate that the keys stand on, a frame; -1 for none. */
  current: number;
  dimmed: ReadonlySet<number>;
  links: boolean;
}

const NEAR = 12; // px
const MOST_RINGS = 3000;
const DIM = 0.08;
const STRONG = 0.6;
const INKS = [..."01234567"].map((one) => `name${one}`);

export function MapView({
  space,
  on,
  cross,
  onHover,
  onPick,
  onKey,
}: {
  space: Space;
  on: OnMap;
  /** mm on the map; null where nothing plays. */
  cross: ReadonlySignal<[number, number] | null>;
  onHover: (frame: number) => void;
  onPick: (candidate: number) => void;
  onKey: (event: KeyboardEvent) => void;
}) {
  const host = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const over = useRef<HTMLCanvasElement>(null);
  const cloud = useRef<Cloud | null>(null);
  const view = useRef<View>({ x: 0, y: 0, scale: 1 });
  const pending = useRef(0);
  const now = useRef(on);
  now.current = on;
  const grid = useMemo(() => new Grid(space.places), [space]);
  const own = useMemo(() => placesOf(space, on.level.candidates), [space, on.level]);
  const ownGrid = useMemo(() => new Grid(own), [own]);
  const lines = useMemo(() => linesOf(own, on.level), [own]);
  const drawn = useRef({ own, lines });
  drawn.current = { own, lines };

  const ask = () => {
    if (!pending.current)
      pending.current = requestAnimationFrame(() => {
        pending.current = 0;
        cloud.current?.look(view.current);
        if (over.current && host.current)
          drawOver(over.current, host.current, space, now.current, drawn.current, view.current, cross.peek());
      });
  };
  const fit = () => {
    const box = host.current;
    if (!box) return;
    view.current = fitted(space.places, box.clientWidth, box.clientHeight);
    ask();
  };

  useEffect(() => {
    const kinds = Uint8Array.from(space.take, (take) => take % INKS.length);
    try {
      cloud.current = new Cloud(canvas.current!, space.places, kinds);
    } catch {
      cloud.current = null; // Without WebGL the candidates are still there.
    }
    const resize = () => {
      const box = host.current;
      if (!box) return;
      cloud.current?.resize(box.clientWidth, box.clientHeight);
      const ratio = Math.min(2, devicePixelRatio);
      over.current!.width = box.clientWidth * ratio;
      over.current!.height = box.clientHeight * ratio;
      ask();
    };
    const observer = new ResizeObserver(resize);
    observer.observe(host.current!);
    resize();
    fit();
    performance.mark("map-drawn");
    return () => {
      observer.disconnect();
      cancelAnimationFrame(pending.current);
      pending.current = 0;
      cloud.current?.close();
      cloud.current = null;
    };
  }, [space]);
  useEffect(
    () =>
      effect(() => {
        look.value;
        cloud.current?.inks([...INKS, "text3"].map((one) => colour(one)));
        ask();
      }),
    [space],
  );
  useEffect(() => {
    cloud.current?.dim(Float32Array.from(space.take, (take) => (on.dimmed.has(take) ? DIM : STRONG)));
  }, [space, on.dimmed]);
  useEffect(
    () =>
      effect(() => {
        cross.value;
        ask();
      }),
    [space, cross],
  );
  useEffect(ask, [on, own]);

  const at = (event: MouseEvent): [number, number] => {
    const box = host.current!.getBoundingClientRect();
    const { x, y, scale } = view.current;
    return [
      x + (event.clientX - box.left - box.width / 2) / scale,
      y - (event.clientY - box.top - box.height / 2) / scale,
    ];
  };
  const under = (event: MouseEvent): { candidate: number; frame: number } => {
    const [x, y] = at(event);
    const within = NEAR / view.current.scale;
    const candidate = ownGrid.nearest(x, y, within);
    if (candidate >= 0) return { candidate, frame: numberAt(on.level.candidates, candidate) };
    return { candidate, frame: grid.nearest(x, y, within) };
  };
  const zoom = (x: number, y: number, by: number) => {
    const before = view.current;
    const scale = before.scale * by;
    view.current = {
      scale,
      x: x - ((x - before.x) * before.scale) / scale,
      y: y - ((y - before.y) * before.scale) / scale,
    };
    ask();
  };
  const drag = useRef<{ x: number; y: number; far: number } | null>(null);
  return (
    <div
      class="faces-map"
      ref={host}
      role="application"
      tabIndex={0}
      aria-label={f("label.mapLabel", { n: space.summary.frames })}
      onKeyDown={(event) => {
        if (event.key === "+" || event.key === "-")
          zoom(view.current.x, view.current.y, event.key === "+" ? 1.25 : 0.8);
        else onKey(event);
      }}
      onWheel={(event) => {
        event.preventDefault();
        zoom(...at(event), Math.exp(-event.deltaY / 400));
      }}
      onDblClick={fit}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        drag.current = { x: event.clientX, y: event.clientY, far: 0 };
      }}
      onPointerMove={(event) => {
        const from = drag.current;
        if (!from) {
          const found = under(event);
          host.current!.style.cursor = found.candidate >= 0 ? "pointer" : "grab";
          onHover(found.frame);
          return;
        }
        const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
        from.far += Math.abs(dx) + Math.abs(dy);
        [from.x, from.y] = [event.clientX, event.clientY];
        view.current = {
          ...view.current,
          x: view.current.x - dx / view.current.scale,
          y: view.current.y + dy / view.current.scale,
        };
        ask();
      }}
      onPointerLeave={() => onHover(-1)}
      onPointerUp={(event) => {
        const moved = (drag.current?.far ?? 0) > 4;
        drag.current = null;
        const found = under(event);
        if (!moved && found.candidate >= 0) onPick(found.candidate);
      }}
    >
      <canvas ref={canvas} />
      <canvas ref={over} />
      <button
        type="button"
        class="button quiet icon faces-fit"
        aria-label={f("button.fit")}
        title={f("button.fit")}
        onPointerDown={(event) => event.stopPropagation()}
        onPointerUp={(event) => event.stopPropagation()}
        onClick={fit}
      >
        <Icon name="search" />
      </button>
    </div>
  );
}

function placesOf(space: Space, frames: ArrayLike<number>): Float32Array {
  const found = new Float32Array(frames.length * 2);
  for (let at = 0; at < frames.length; at++) {
    found[at * 2] = numberAt(space.places, numberAt(frames, at) * 2);
    found[at * 2 + 1] = numberAt(space.places, numberAt(frames, at) * 2 + 1);
  }
  return found;
}

function linesOf(own: Float32Array, level: Level): { plain: Path2D; bridges: Path2D } {
  const [plain, bridges] = [new Path2D(), new Path2D()];
  const { a, b, bridge } = level.links;
  if (a.length <= MOST_LINKS)
    for (let at = 0; at < a.length; at++) {
      const path = bridge[at] ? bridges : plain;
      path.moveTo(numberAt(own, numberAt(a, at) * 2), numberAt(own, numberAt(a, at) * 2 + 1));
      path.lineTo(numberAt(own, numberAt(b, at) * 2), numberAt(own, numberAt(b, at) * 2 + 1));
    }
  return { plain, bridges };
}

function fitted(places: Float32Array, width: number, height: number): View {
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let at = 0; at < places.length; at += 2) {
    left = Math.min(left, numberAt(places, at));
    right = Math.max(right, numberAt(places, at));
    low = Math.min(low, numberAt(places, at + 1));
    high = Math.max(high, numberAt(places, at + 1));
  }
  const scale = Math.min(Math.max(1, width - 80) / (right - left || 1), Math.max(1, height - 80) / (high - low || 1));
  return { x: (left + right) / 2, y: (low + high) / 2, scale };
}

function drawOver(
  canvas: HTMLCanvasElement,
  host: HTMLElement,
  space: Space,
  on: OnMap,
  drawn: { own: Float32Array; lines: ReturnType<typeof linesOf> },
  view: View,
  cross: [number, number] | null,
): void {
  const pen = canvas.getContext("2d")!;
  const ratio = canvas.width / Math.max(1, host.clientWidth);
  const [width, height] = [host.clientWidth, host.clientHeight];
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const x = (value: number) => (value - view.x) * view.scale + width / 2;
  const y = (value: number) => height / 2 - (value - view.y) * view.scale;
  const place = (frame: number): [number, number] => [
    x(numberAt(space.places, frame * 2)),
    y(numberAt(space.places, frame * 2 + 1)),
  ];
  if (on.links) {
    pen.save();
    pen.setTransform(
      ratio * view.scale,
      0,
      0,
      -ratio * view.scale,
      ratio * (width / 2 - view.x * view.scale),
      ratio * (height / 2 + view.y * view.scale),
    );
    pen.lineWidth = 1 / view.scale;
    pen.strokeStyle = colour("edge");
    pen.globalAlpha = 0.6;
    pen.stroke(drawn.lines.plain);
    pen.setLineDash([6 / view.scale, 4 / view.scale]);
    pen.strokeStyle = colour("warn");
    pen.stroke(drawn.lines.bridges);
    pen.restore();
  }
  const line = (frames: ArrayLike<number>, ink: string, wide: number, dash: number[] = []) => {
    if (frames.length < 2) return;
    pen.save();
    pen.lineWidth = wide;
    pen.lineJoin = "round";
    pen.setLineDash(dash);
    pen.strokeStyle = colour(ink);
    pen.beginPath();
    for (let at = 0; at < frames.length; at++) pen.lineTo(...place(numberAt(frames, at)));
    pen.stroke();
    pen.restore();
  };
  line(on.walk.length ? on.walk : on.keys, "accent", 3);
  line(on.route, "select", 2, [3, 5]);
  const ring = (at: [number, number], size: number, ink: string, fill: string) => {
    pen.beginPath();
    pen.arc(...at, size, 0, Math.PI * 2);
    pen.fillStyle = colour(fill);
    pen.fill();
    pen.lineWidth = 1.75;
    pen.strokeStyle = colour(ink);
    pen.stroke();
  };
  const { candidates } = on.level;
  const near =
    on.current >= 0 && !on.walk.length
      ? new Set((on.level.neighbours[candidates.indexOf(on.keys.at(-1) ?? on.current)] ?? []).map((one) => one.to))
      : new Set<number>();
  if (candidates.length <= MOST_RINGS)
    for (let at = 0; at < candidates.length; at++) {
      const spot: [number, number] = [x(numberAt(drawn.own, at * 2)), y(numberAt(drawn.own, at * 2 + 1))];
      if (spot[0] < -9 || spot[1] < -9 || spot[0] > width + 9 || spot[1] > height + 9) continue;
      ring(spot, near.has(at) ? 6.5 : 5, near.has(at) ? "accent" : "text3", "well");
    }
  for (const frame of on.offers) ring(place(frame), 8, "select", "well");
  on.keys.forEach((frame, at) => {
    const spot = place(frame);
    ring(spot, 7, "accent", "accent");
    pen.font = `600 12px ${getComputedStyle(host).fontFamily}`;
    pen.lineWidth = 3;
    pen.strokeStyle = colour("well");
    pen.strokeText(String(at + 1), spot[0] + 10, spot[1] - 8);
    pen.fillStyle = colour("text");
    pen.fillText(String(at + 1), spot[0] + 10, spot[1] - 8);
  });
  if (on.current >= 0) {
    pen.beginPath();
    pen.arc(...place(on.current), 11, 0, Math.PI * 2);
    pen.lineWidth = 2;
    pen.strokeStyle = colour("select");
    pen.stroke();
  }
  if (!cross) return;
  const [cx, cy] = [x(cross[0]), y(cross[1])];
  for (const [ink, wide] of [
    ["well", 6],
    ["select", 2.5],
  ] as const) {
    pen.lineWidth = wide;
    pen.strokeStyle = colour(ink);
    pen.beginPath();
    pen.moveTo(cx - 9, cy);
    pen.lineTo(cx + 9, cy);
    pen.moveTo(cx, cy - 9);
    pen.lineTo(cx, cy + 9);
    pen.stroke();
  }
}
