/** A storyboard: pieces of stored clips in an order, with transitions between them. Kept in the address. */
export interface Piece {
  key: number;
  document: string;
  name: string;
  /** Positions from 1, both included. */
  first: number;
  last: number;
  /** Frames of the whole clip, once it is known. */
  frames: number;
}

let lastKey = 0;
export const pieceOf = (document: string, name = "", first = 1, last = 0, frames = 0): Piece => ({ key: ++lastKey, document, name, first, last, frames });

/** "id:first-last,id" as an address has it. */
export function parsePieces(text: string): Piece[] {
  return text.split(",").filter(Boolean).map((part) => {
    const [document, range = ""] = part.split(":");
    const [first, last] = range.split("-").map(Number);
    return pieceOf(document, "", first || 1, last || 0);
  });
}

/** Of a whole clip, or one whose frames are not known yet, no range is written. */
export const writePieces = (pieces: readonly Piece[]): string =>
  pieces.map(({ document, first, last, frames }) => (first === 1 && (!last || last === frames) ? document : `${document}:${first}-${last || ""}`)).join(",");

/** Cut a piece before a frame; unchanged where the frame is no inner one. */
export function splitPiece(pieces: readonly Piece[], index: number, frame: number): Piece[] {
  const piece = pieces[index];
  if (!piece || frame <= piece.first || frame > piece.last) return [...pieces];
  return pieces.flatMap((one, at) => (at === index ? [{ ...one, last: frame - 1 }, { ...one, key: ++lastKey, first: frame }] : [one]));
}

export function movePiece(pieces: readonly Piece[], from: number, to: number): Piece[] {
  const next = [...pieces];
  const [piece] = next.splice(from, 1);
  next.splice(Math.max(0, Math.min(next.length, to)), 0, piece);
  return next;
}

/** Which piece plays at a frame (from 0) of pieces put end to end, and its own frame (from 0). */
export function pieceAt(pieces: readonly Piece[], frame: number): { index: number; frame: number } | null {
  let start = 0;
  for (const [index, piece] of pieces.entries()) {
    const size = Math.max(0, piece.last - piece.first + 1);
    if (frame < start + size) return { index, frame: piece.first - 1 + frame - start };
    start += size;
  }
  return null;
}
