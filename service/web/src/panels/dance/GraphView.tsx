/** The graph, drawn: nodes are bars, their loops move under the pointer; an edge that is pressed plays. Laid out in a worker. */
import { itemAt, numberAt } from "../../lists";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { colour, look } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import { number } from "../../words";
import { BarLoop } from "./BarLoop";
import { edgeAt, type Graph, type Node } from "./graph";
import type { LaidOut, LayoutWish } from "./layout.worker";
import { d } from "./words";

const EDGE = 22; // px around the picture
const RADII = [4, 9];
const NAMED = 6.5; // px from which on a node has room for its number
const HIT_EDGE = 5;

interface Hover {
  node: number;
  edge: number;
  x: number;
  y: number;
}
const NOWHERE: Hover = { node: -1, edge: -1, x: 0, y: 0 };

export function GraphView({
  graph,
  by,
  names,
  chosen,
  start,
  onPick,
  onPlay,
}: {
  graph: Graph;
  by: "clip" | "component";
  names: (document: string) => string;
  /** Bars that are allowed at the position that is chosen. */
  chosen: readonly number[];
  start: number;
  onPick: (node: Node) => void;
  onPlay: (from: Node, to: Node) => void;
}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [places, setPlaces] = useState<Float32Array | null>(null);
  const [hover, setHover] = useState<Hover>(NOWHERE);
  const [focus, setFocus] = useState(-1);
  const [size, setSize] = useState<[number, number]>([0, 0]);
  const turn = useRef(0);
  const skin = look.value;
  const worker = useMemo(() => new Worker(new URL("./layout.worker.ts", import.meta.url), { type: "module" }), []);
  useEffect(() => {
    worker.onmessage = ({ data }: MessageEvent<LaidOut>) => {
      if (data.turn === turn.current) setPlaces(data.places);
    };
    return () => worker.terminate();
  }, []);
  useEffect(() => {
    turn.current++;
    const wish: LayoutWish = {
      turn: turn.current,
      count: graph.nodes.length,
      links: graph.edges,
      before: places?.length === graph.nodes.length * 2 ? places : undefined,
    };
    worker.postMessage(wish);
  }, [graph]);
  useEffect(() => {
    const element = canvas.current!;
    const observer = new ResizeObserver(() => setSize([element.clientWidth, element.clientHeight]));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  // Places in pixels.
  const spots = useMemo(() => {
    if (places?.length !== graph.nodes.length * 2) return null;
    const [width, height] = size;
    const scale = Math.min((width - 2 * EDGE) / 3.4, (height - 2 * EDGE) / 2);
    return places.map((value, at) => (at % 2 ? height / 2 + value * scale : width / 2 + value * scale));
  }, [places, size, graph]);
  const radius = useMemo(() => (spots ? radiusOf(spots) : 0), [spots]);
  useEffect(() => {
    if (spots)
      draw(canvas.current!, graph, spots, radius, by, hover.node >= 0 ? hover.node : focus, hover.edge, chosen, start);
  }, [spots, graph, by, hover.node, hover.edge, focus, chosen.join(), start, skin]);
  const under = (event: MouseEvent): Hover => {
    const box = canvas.current!.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    if (!spots) return NOWHERE;
    let [node, least] = [-1, radius + 2];
    for (let at = 0; at < graph.nodes.length; at++) {
      const away = Math.hypot(numberAt(spots, at * 2) - x, numberAt(spots, at * 2 + 1) - y);
      if (away < least) [node, least] = [at, away];
    }
    return { node, edge: node < 0 ? edgeAt(graph.edges, spots, x, y, HIT_EDGE) : -1, x, y };
  };
  const shown = hover.node >= 0 ? hover.node : focus;
  const edge = graph.edges[hover.edge];
  const loopAt = shown >= 0 && spots ? ([numberAt(spots, shown * 2), numberAt(spots, shown * 2 + 1)] as const) : null;
  return (
    <div class="bench-canvas" data-laid={spots ? "" : undefined}>
      <canvas
        ref={canvas}
        role="img"
        aria-label={d("label.graphOf", {
          bars: graph.nodes.length,
          edges: graph.all,
          components: new Set(graph.components).size,
        })}
        class={hover.node >= 0 || edge ? "hits" : ""}
        onPointerMove={(event) => {
          const next = under(event);
          if (next.node !== hover.node || next.edge !== hover.edge) setHover(next);
        }}
        onPointerLeave={() => setHover(NOWHERE)}
        onClick={(event) => {
          const { node, edge: hit } = under(event);
          if (node >= 0) onPick(itemAt(graph.nodes, node));
          else if (hit >= 0)
            onPlay(
              itemAt(graph.nodes, itemAt(graph.edges, hit).from),
              itemAt(graph.nodes, itemAt(graph.edges, hit).to),
            );
        }}
      />
      {!spots && <div class="busy" />}
      {loopAt && (
        <div
          class="bar-loop"
          style={{
            left: `${Math.min(Math.max(8, loopAt[0] + 14), Math.max(8, size[0] - 148))}px`,
            top: `${Math.min(Math.max(8, loopAt[1] - 150), Math.max(8, size[1] - 170))}px`,
          }}
        >
          <BarLoop place={itemAt(graph.nodes, shown)} />
          <span class="cut">
            {d("label.barOf", { n: itemAt(graph.nodes, shown).bar, name: names(itemAt(graph.nodes, shown).document) })}
          </span>
        </div>
      )}
      {edge && (
        <span class="lane-tip" style={{ left: `${hover.x}px`, top: `${Math.max(2, hover.y - 30)}px` }}>
          {d("label.edgeOf", { from: itemAt(graph.nodes, edge.from).bar, to: itemAt(graph.nodes, edge.to).bar })} ·{" "}
          {edge.natural ? d("label.naturalWord") : number(edge.distance, 3)}
        </span>
      )}
      <Walker graph={graph} focus={focus} names={names} onFocus={setFocus} onPick={onPick} onPlay={onPlay} />
    </div>
  );
}

/** The bars as a list of one stop: arrows from bar to bar, Enter takes one, P plays its nearest edge. */
function Walker({
  graph,
  focus,
  names,
  onFocus,
  onPick,
  onPlay,
}: {
  graph: Graph;
  focus: number;
  names: (document: string) => string;
  onFocus: (node: number) => void;
  onPick: (node: Node) => void;
  onPlay: (from: Node, to: Node) => void;
}) {
  const key = (event: KeyboardEvent) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (by) onFocus((Math.max(0, focus) + by + graph.nodes.length) % graph.nodes.length);
    else if (event.key === "Enter" && focus >= 0) onPick(itemAt(graph.nodes, focus));
    else if (event.code === "KeyP" && focus >= 0) {
      const nearest = graph.edges.filter((one) => one.from === focus).sort((a, b) => a.distance - b.distance)[0];
      if (nearest) onPlay(itemAt(graph.nodes, focus), itemAt(graph.nodes, nearest.to));
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <ul
      class="unseen"
      role="listbox"
      tabIndex={0}
      aria-label={d("label.graph")}
      aria-activedescendant={focus >= 0 ? `node-${focus}` : undefined}
      onKeyDown={key}
      onFocus={() => onFocus(Math.max(0, focus))}
      onBlur={() => onFocus(-1)}
    >
      {graph.nodes.map((node, at) => (
        <li key={node.bar} id={`node-${at}`} role="option" aria-selected={at === focus}>
          {d("label.barOf", { n: node.bar, name: names(node.document) })}
        </li>
      ))}
    </ul>
  );
}

/** As large as the bars have room: half of what most are away from their nearest. */
function radiusOf(spots: Float32Array): number {
  const nearest: number[] = [];
  for (let a = 0; a < spots.length; a += 2) {
    let least = Infinity;
    for (let b = 0; b < spots.length; b += 2)
      if (a !== b)
        least = Math.min(
          least,
          Math.hypot(numberAt(spots, a) - numberAt(spots, b), numberAt(spots, a + 1) - numberAt(spots, b + 1)),
        );
    nearest.push(least);
  }
  nearest.sort((a, b) => a - b);
  return Math.max(numberAt(RADII, 0), Math.min(numberAt(RADII, 1), (nearest[nearest.length >> 2] ?? 0) / 2 - 0.5));
}

const SHADES = 4; // of edges by distance

function draw(
  canvas: HTMLCanvasElement,
  graph: Graph,
  spots: Float32Array,
  radius: number,
  by: "clip" | "component",
  lit: number,
  litEdge: number,
  chosen: readonly number[],
  start: number,
): void {
  const { pen } = penOf(canvas);
  const dense = Math.min(1, 500 / Math.max(1, graph.edges.length));
  const line = (at: number) => {
    const { from, to } = itemAt(graph.edges, at);
    pen.moveTo(numberAt(spots, from * 2), numberAt(spots, from * 2 + 1));
    pen.lineTo(numberAt(spots, to * 2), numberAt(spots, to * 2 + 1));
  };
  const ink = colour("text3");
  for (let shade = 0; shade < SHADES; shade++) {
    pen.beginPath();
    graph.edges.forEach((edge, at) => {
      if (
        !edge.natural &&
        Math.min(SHADES - 1, Math.floor((edge.distance / (graph.threshold || 1)) * SHADES)) === shade
      )
        line(at);
    });
    pen.strokeStyle = ink;
    pen.globalAlpha = (0.12 + 0.5 * dense) * (1 - shade / (SHADES + 1));
    pen.lineWidth = 1.6 - shade * 0.3;
    pen.stroke();
  }
  pen.beginPath();
  graph.edges.forEach((edge, at) => {
    if (edge.natural) line(at);
  });
  pen.strokeStyle = colour("text2");
  pen.globalAlpha = 0.9;
  pen.lineWidth = 2.4;
  pen.stroke();
  pen.globalAlpha = 1;
  if (lit >= 0 || litEdge >= 0) {
    pen.strokeStyle = colour("accent");
    graph.edges.forEach((edge, at) => {
      if (at === litEdge || edge.from === lit)
        arrow(pen, spots, radius, edge.from, edge.to, at === litEdge ? 2.5 : 1.4);
    });
  }
  const family = getComputedStyle(canvas).fontFamily;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.font = `600 9px ${family}`;
  graph.nodes.forEach((node, at) => {
    const [x, y] = [numberAt(spots, at * 2), numberAt(spots, at * 2 + 1)];
    const number = by === "clip" ? node.clip : (graph.components[at] ?? 0);
    pen.globalAlpha = graph.components[at] === 0 ? 1 : 0.55; // Where a dance cannot go on for ever.
    pen.fillStyle = colour(`name${number % 8}`);
    pen.beginPath();
    pen.arc(x, y, radius, 0, 7);
    pen.fill();
    pen.globalAlpha = 1;
    const marked = chosen.includes(node.bar) || at === lit || node.bar === start;
    if (marked) {
      pen.strokeStyle = colour(at === lit ? "accent" : "select");
      pen.lineWidth = 2.5;
      pen.beginPath();
      pen.arc(x, y, radius + 2.5, 0, 7);
      pen.stroke();
    }
    if (radius < NAMED) return;
    pen.fillStyle = colour("nameink");
    pen.fillText(String(node.bar), x, y + 0.5);
  });
}

function arrow(
  pen: CanvasRenderingContext2D,
  spots: Float32Array,
  radius: number,
  from: number,
  to: number,
  width: number,
): void {
  const [ax, ay, bx, by] = [
    numberAt(spots, from * 2),
    numberAt(spots, from * 2 + 1),
    numberAt(spots, to * 2),
    numberAt(spots, to * 2 + 1),
  ];
  const angle = Math.atan2(by - ay, bx - ax);
  const [x, y] = [bx - Math.cos(angle) * (radius + 2), by - Math.sin(angle) * (radius + 2)];
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(ax, ay);
  pen.lineTo(x, y);
  for (const turn of [2.7, -2.7]) {
    pen.moveTo(x, y);
    pen.lineTo(x + 7 * Math.cos(angle + turn), y + 7 * Math.sin(angle + turn));
  }
  pen.stroke();
}
