/** Links between candidates, and the shortest way over them. */

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
    const [one, other, length, bridge] = [links.a[at], links.b[at], links.length[at], Boolean(links.bridge[at])];
    found[one].push({ to: other, length, bridge });
    found[other].push({ to: one, length, bridge });
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
    for (const one of open) if (at < 0 || far[one] < far[at]) at = one;
    if (at === to) break;
    open.delete(at);
    for (const { to: next, length } of neighbours[at]) {
      if (far[at] + length >= far[next]) continue;
      far[next] = far[at] + length;
      before[next] = at;
      open.add(next);
    }
  }
  if (!Number.isFinite(far[to])) return null;
  const way = [to];
  while (way[0] !== from) way.unshift(before[way[0]]);
  return { way, length: far[to] };
}
