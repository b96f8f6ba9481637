/** Links between candidates, and the shortest way over them. */
import { itemAt, numberAt } from "../../lists";

export interface Links {
  a: ArrayLike<number>;
  b: ArrayLike<number>;
  /** mm. */
  length: ArrayLike<number>;
  bridge: ArrayLike<number>;
}
export interface Neighbour {
  to: number;
  length: number;
  bridge: boolean;
}

/** Of each candidate those it is linked to, the nearest first. */
export function neighboursOf(count: number, links: Links): Neighbour[][] {
  const found: Neighbour[][] = Array.from({ length: count }, () => []);
  for (let at = 0; at < links.a.length; at++) {
    const [one, other, length, bridge] = [
      numberAt(links.a, at),
      numberAt(links.b, at),
      numberAt(links.length, at),
      Boolean(links.bridge[at]),
    ];
    itemAt(found, one).push({ to: other, length, bridge });
    itemAt(found, other).push({ to: one, length, bridge });
  }
  for (const list of found) list.sort((one, other) => one.length - other.length);
  return found;
}

/** The shortest way from one candidate to another, both included, and its length; null where none leads there. */
export function shortestRoute(
  neighbours: Neighbour[][],
  from: number,
  to: number,
): { way: number[]; length: number } | null {
  const far = new Float64Array(neighbours.length).fill(Infinity);
  const before = new Int32Array(neighbours.length).fill(-1);
  const open = new Set([from]);
  far[from] = 0;
  while (open.size) {
    let at = -1;
    for (const one of open) if (at < 0 || numberAt(far, one) < numberAt(far, at)) at = one;
    if (at === to) break;
    open.delete(at);
    for (const { to: next, length } of itemAt(neighbours, at)) {
      if (numberAt(far, at) + length >= numberAt(far, next)) continue;
      far[next] = numberAt(far, at) + length;
      before[next] = at;
      open.add(next);
    }
  }
  if (!Number.isFinite(far[to])) return null;
  const way = [to];
  while (way[0] !== from) way.unshift(numberAt(before, numberAt(way, 0)));
  return { way, length: numberAt(far, to) };
}
