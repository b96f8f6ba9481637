/** A tidy picture of a hierarchy: depth to the right, leaves below each other, parents in the middle of their children. */
import { itemAt, numberAt } from "../../lists";
export interface Place {
  x: number;
  y: number;
}

/** Places of nodes, in units of levels and of leaves. parents: -1 at roots; parents stand before children. */
export function tidy(parents: ArrayLike<number>): { places: Place[]; width: number; height: number } {
  const children: number[][] = Array.from({ length: parents.length }, () => []);
  const roots: number[] = [];
  for (let node = 0; node < parents.length; node++)
    (numberAt(parents, node) < 0 ? roots : itemAt(children, numberAt(parents, node))).push(node);
  const places: Place[] = new Array(parents.length);
  let leaves = 0;
  let deepest = 0;
  const visit = (node: number, depth: number): number => {
    deepest = Math.max(deepest, depth);
    const rows = itemAt(children, node).map((child) => visit(child, depth + 1));
    const y = rows.length ? (numberAt(rows, 0) + numberAt(rows, rows.length - 1)) / 2 : leaves++;
    places[node] = { x: depth, y };
    return y;
  };
  for (const root of roots) visit(root, 0);
  return { places, width: deepest + 1, height: leaves };
}
