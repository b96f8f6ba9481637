/** Where the bars of a graph are drawn: near ones attract, all repel. */
import { numberAt } from "../../lists";
import { forceCollide, forceLink, forceManyBody, forceSimulation, forceX, forceY } from "d3-force";

export interface Link {
  from: number;
  to: number;
  distance: number;
  natural: boolean;
}
interface Node {
  index?: number;
  x?: number;
  y?: number;
}

const STEPS = 220;
const WIDE = 1.7; // windows are wider than high

/** (2 * count,) of places, centred, within ±WIDE and ±1; the same for the same graph. before: places to begin from. */
export function layOut(count: number, links: readonly Link[], before?: Float32Array): Float32Array {
  const nodes: Node[] = Array.from({ length: count }, (_, at) =>
    before?.length === count * 2 ? { x: numberAt(before, at * 2) * 100, y: numberAt(before, at * 2 + 1) * 100 } : {},
  );
  const greatest = Math.max(1e-6, ...links.map((one) => one.distance));
  const between = links.map((one) => ({
    source: one.from,
    target: one.to,
    near: one.natural ? 1 : 1 - one.distance / (1.5 * greatest),
  }));
  const simulation = forceSimulation(nodes)
    .force(
      "links",
      forceLink<Node, (typeof between)[number]>(between)
        .distance((one) => 22 + 30 * (1 - one.near))
        .strength((one) => (0.1 + 0.9 * one.near) / Math.max(1, Math.sqrt(links.length / Math.max(1, count)))),
    )
    .force("apart", forceManyBody().strength(-90).distanceMax(300))
    .force("room", forceCollide(16).iterations(2))
    .force("x", forceX(0).strength(0.05))
    .force("y", forceY(0).strength(0.05 * WIDE))
    .stop();
  const steps = before?.length === count * 2 ? STEPS / 2 : STEPS;
  for (let step = 0; step < steps; step++) simulation.tick();
  const box = (of: (node: Node) => number): [number, number] => {
    const all = nodes.map(of);
    return all.length ? [(Math.min(...all) + Math.max(...all)) / 2, (Math.max(...all) - Math.min(...all)) / 2] : [0, 0];
  };
  const [[x, wide], [y, high]] = [box((node) => node.x!), box((node) => node.y!)];
  const scale = Math.max(1e-6, wide / WIDE, high);
  return Float32Array.from(nodes.flatMap((node) => [(node.x! - x) / scale, (node.y! - y) / scale]));
}
