/** The example of a search for similar poses and motions, as the address of the page has it. */
import type { Schemas } from "../../../api/client";
import { pieceOf, writePieces } from "../../../state/editing/composition";

export type Hit = Schemas["SearchHit"];
export interface Example {
  /** Frames, positions from 1. */
  first: number;
  /** Absent: a pose. */
  last?: number;
}

/** "30" is the pose of a frame, "10-40" a motion; null: no example. */
export function parseExample(text: string): Example | null {
  const found = /^(\d{1,9})(?:-(\d{1,9}))?$/.exec(text);
  const first = Number(found?.[1]);
  const last = found?.[2] === undefined ? undefined : Number(found[2]);
  if (!found || first < 1 || (last !== undefined && last < first)) return null;
  return last === undefined ? { first } : { first, last };
}

export const writeExample = ({ first, last }: Example): string =>
  last === undefined ? `${first}` : `${first}-${last}`;

/** The hits up to a distance: they are in the order of their distances. */
export const within = (hits: readonly Hit[], most: number): Hit[] => hits.filter((one) => one.distance <= most);

/** A table of labels, as the server imports it. */
export function labelTable(hits: readonly Hit[], name: string): string {
  const quoted = `"${name.replaceAll('"', '""')}"`;
  const rows = hits.map(({ document, first, last }) => `${document},${quoted},${first},${last}`);
  return ["document,label,first,last", ...rows, ""].join("\n");
}

/** The address of the composer with the ranges as its pieces. */
export const composerOf = (hits: readonly Hit[]): string =>
  `/compose?s=${writePieces(hits.map(({ document, name, first, last }) => pieceOf(document, name, first, last)))}`;

export const documentsOf = (hits: readonly Hit[]): string[] => [...new Set(hits.map((one) => one.document))];
