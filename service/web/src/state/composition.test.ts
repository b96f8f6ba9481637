import { describe, expect, it } from "vitest";
import { random, type Random } from "../testing/random";
import { movePiece, parsePieces, pieceAt, pieceOf, splitPiece, writePieces, type Piece } from "./composition";

const drawn = (draw: Random): Piece[] =>
  Array.from({ length: draw.whole(0, 5) }, (_, index) => {
    const frames = draw.whole(1, 30);
    const first = draw.whole(1, frames);
    return pieceOf(`id-${index}`.replace("-", ""), "", first, draw.whole(first, frames), frames);
  });
/** The frames of all pieces, one after the other. */
const played = (pieces: readonly Piece[]) => pieces.flatMap(({ document, first, last }) => Array.from({ length: last - first + 1 }, (_, at) => `${document} ${first + at}`));

describe("pieces in an address", () => {
  it("come back as they were; whole clips need no range", () => {
    for (let seed = 0; seed < 200; seed++) {
      const pieces = drawn(random(seed));
      const found = parsePieces(writePieces(pieces));
      expect(found.map(({ document }) => document)).toEqual(pieces.map(({ document }) => document));
      found.forEach((one, index) => {
        const whole = pieces[index].first === 1 && pieces[index].last === pieces[index].frames;
        expect([one.first, one.last]).toEqual(whole ? [1, 0] : [pieces[index].first, pieces[index].last]);
      });
      expect(new Set(found.map(({ key }) => key)).size).toBe(found.length);
    }
    expect(writePieces(parsePieces("a:3-9,b,a"))).toBe("a:3-9,b,a");
  });

  it("keep their beginning while their end is not known", () => expect(writePieces(parsePieces("a:3-,b"))).toBe("a:3-,b"));
});

describe("pieces put end to end", () => {
  it("play each frame of each piece", () => {
    for (let seed = 0; seed < 100; seed++) {
      const pieces = drawn(random(seed));
      const all = played(pieces);
      const found = Array.from({ length: all.length + 3 }, (_, frame) => pieceAt(pieces, frame)).map((at) => at && `${pieces[at.index].document} ${at.frame + 1}`);
      expect(found).toEqual([...all, null, null, null]);
    }
  });

  it("play the same after a cut, with keys of their own", () => {
    for (let seed = 0; seed < 200; seed++) {
      const draw = random(seed);
      const pieces = drawn(draw);
      const index = draw.whole(0, 5);
      const frame = draw.whole(0, 32);
      const cut = splitPiece(pieces, index, frame);
      expect(played(cut)).toEqual(played(pieces));
      expect(new Set(cut.map(({ key }) => key)).size).toBe(cut.length);
      const inner = pieces[index] && pieces[index].first < frame && frame <= pieces[index].last;
      expect(cut.length).toBe(pieces.length + (inner ? 1 : 0));
      if (inner) expect(cut[index + 1].first).toBe(frame);
    }
  });

  it("change places", () => {
    const [a, b, c] = parsePieces("a,b,c");
    expect(movePiece([a, b, c], 0, 2)).toEqual([b, c, a]);
    expect(movePiece([a, b, c], 2, 0)).toEqual([c, a, b]);
    expect(movePiece([a, b, c], 1, 9)).toEqual([a, c, b]);
    expect(movePiece([a, b, c], 1, -4)).toEqual([b, a, c]);
  });
});
