/** The graph of bars as the bench draws it. */
import { itemAt, numberAt } from "../../lists";
import { partOf, applyResult, type Result } from "../../api/results";
import type { Schemas } from "../../api/client";
import type { Place } from "./bench";

export interface Node extends Place {
  kept: boolean;
  clip: number;
}
export interface Edge {
  from: number;
  to: number;
  distance: number;
  natural: boolean;
}
export interface Graph {
  id: string;
  nodes: Node[];
  edges: Edge[];
  components: number[];
  threshold: number;
  least: number;
  greatest: number;
  all: number;
}

/** The bars of a result that holds a graph. documents: in the order of the clips' colours. */
export function nodesOf(result: Result, documents: readonly string[]): Node[] {
  const given = (result.parts.graph?.data.nodes ?? []) as {
    id: number;
    document: string;
    bar: number;
    first: number;
    last: number;
    kept: boolean;
  }[];
  return given.map((one) => ({
    bar: one.id,
    document: one.document,
    number: one.bar,
    first: one.first,
    last: one.last,
    kept: one.kept,
    clip: Math.max(0, documents.indexOf(one.document)),
  }));
}

/** Its edges and components with a threshold; null: that of the graph. */
export async function graphAt(
  result: Result,
  documents: readonly string[],
  threshold: number | null,
  signal?: AbortSignal,
): Promise<Graph> {
  const own = partOf(result, "graph").data.threshold as number;
  const { value } = await applyResult<Schemas["GraphEdges"]>(
    result.id,
    "edges",
    { threshold: threshold ?? own },
    {},
    signal,
  );
  return {
    id: result.id,
    nodes: nodesOf(result, documents),
    components: value.components,
    threshold: value.threshold,
    all: value.edges_in_all,
    least: value.least ?? 0,
    greatest: Math.max(value.greatest ?? own, own),
    edges: value.edges.map((one) => ({
      from: one.first - 1,
      to: one.second - 1,
      distance: one.distance,
      natural: one.natural,
    })),
  };
}

/** How many components there are, and how many bars the largest has. */
export function parted(components: readonly number[]): { count: number; largest: number } {
  return { count: new Set(components).size, largest: components.filter((one) => one === 0).length };
}

/** The edge under a point of the plane, within a distance; the direction whose end is nearer. -1: none. */
export function edgeAt(edges: readonly Edge[], places: Float32Array, x: number, y: number, within: number): number {
  let [best, least] = [-1, within];
  let nearEnd = Infinity;
  for (let at = 0; at < edges.length; at++) {
    const { from, to } = itemAt(edges, at);
    const [ax, ay, bx, by] = [
      numberAt(places, from * 2),
      numberAt(places, from * 2 + 1),
      numberAt(places, to * 2),
      numberAt(places, to * 2 + 1),
    ];
    const length = (bx - ax) ** 2 + (by - ay) ** 2 || 1;
    const share = Math.max(0, Math.min(1, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length));
    const away = Math.hypot(ax + share * (bx - ax) - x, ay + share * (by - ay) - y);
    const end = 1 - share;
    if (away < least - 1e-9 || (away <= least + 1e-9 && best >= 0 && end < nearEnd))
      [best, least, nearEnd] = [at, away, end];
  }
  return best;
}
