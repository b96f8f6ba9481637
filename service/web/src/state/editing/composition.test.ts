import { itemAt, numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random, type Random } from "../../testing/random";
import {
  asSegments,
  layerOf,
  learnt,
  movePiece,
  parsePieces,
  pieceOf,
  readBoard,
  sizeOf,
  snapped,
  splitPiece,
  withLayer,
  withLayers,
  withPiece,
  withoutLayer,
  writeBoard,
  writeLayers,
  writePieces,
  type Piece,
} from "./composition";

const drawn = (draw: Random): Piece[] =>
  Array.from({ length: draw.whole(0, 5) }, (_, index) => {
    const frames = draw.whole(1, 30);
    const first = draw.whole(1, frames);
    const last = draw.whole(first, frames);
    return {
      ...pieceOf(`id${index}-a`, "", first, last, frames),
      speed: numberAt([1, 0.5, 1.25, 20], draw.whole(0, 3)),
      mirror: draw() < 0.5,
      transition: draw() < 0.5 ? null : draw.whole(0, 40),
      style: itemAt([null, "bridge", "crossfade", "inertial"] as const, draw.whole(0, 3)),
      layers: Array.from({ length: draw.whole(0, 2) }, () => ({
        ...layerOf("other", "", 2, 9, 30),
        at: draw.whole(1, 9),
        bones: ["left_up_arm", "a+b:c,d"],
        strength: 0.25,
        ease: draw.whole(0, 9),
      })),
    };
  });
/** The frames of all pieces, one after the other. */
const played = (pieces: readonly Piece[]) =>
  pieces.flatMap(({ document, first, last }) =>
    Array.from({ length: last - first + 1 }, (_, at) => `${document} ${first + at}`),
  );
const said = (pieces: readonly Piece[]) =>
  pieces.map(({ key: _, frames: __, layers, ...rest }) => ({
    ...rest,
    layers: layers.map(({ key: ___, frames: ____, ...layer }) => layer),
  }));

describe("a storyboard in an address", () => {
  it("comes back as it was; whole clips need no range", () => {
    for (let seed = 0; seed < 200; seed++) {
      const pieces = drawn(random(seed));
      const found = withLayers(parsePieces(writePieces(pieces)), writeLayers(pieces));
      const whole = (one: Piece) => one.first === 1 && one.last === one.frames;
      expect(said(found)).toEqual(said(pieces.map((one) => (whole(one) ? { ...one, last: 0 } : one))));
      expect(new Set(found.map(({ key }) => key)).size).toBe(found.length);
    }
    expect(writePieces(parsePieces("a:3-9,b,a"))).toBe("a:3-9,b,a");
  });

  it("keeps beginnings while ends are not known, and leaves out what cannot be", () => {
    expect(writePieces(parsePieces("a:3-,b"))).toBe("a:3-,b");
    expect(writePieces(parsePieces("a_x900_t-4_q,b_xnan_t9000"))).toBe("a,b");
    expect(withLayers(parsePieces("a"), "1:x,7:1:1:1:b:d,,1::::").flatMap((one) => one.layers)).toEqual([]);
  });

  it("has its name and what holds for all seams", () => {
    const board = {
      name: "both",
      pieces: [],
      seconds: 0.5,
      transition: 3,
      style: "inertial" as const,
      lockFeet: false,
      matchPhase: true,
    };
    const written = writeBoard(board, "untitled") as Record<string, string | null>;
    expect(readBoard((name) => written[name] ?? "", "untitled")).toEqual(board);
    expect(
      Object.values(
        writeBoard(
          readBoard(() => "", "untitled"),
          "untitled",
        ),
      ).every((one) => one === null),
    ).toBe(true);
  });
});

describe("pieces put end to end", () => {
  it("play the same after a cut, with keys and layers of their own", () => {
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
      if (inner) expect(itemAt(cut, index + 1).first).toBe(frame);
      const layersOf = (list: readonly Piece[]) =>
        list.flatMap((one) => one.layers.map((layer) => one.document + (one.first + layer.at)));
      expect(layersOf(cut).sort()).toEqual(layersOf(pieces).sort());
    }
  });

  it("change places", () => {
    const [a, b, c] = parsePieces("a,b,c");
    expect(movePiece([a!, b!, c!], 0, 2)).toEqual([b, c, a]);
    expect(movePiece([a!, b!, c!], 2, 0)).toEqual([c, a, b]);
    expect(movePiece([a!, b!, c!], 1, 9)).toEqual([a, c, b]);
    expect(movePiece([a!, b!, c!], 1, -4)).toEqual([b, a, c]);
  });

  it("stay within their clips, however they are changed", () => {
    const piece = { ...pieceOf("a", "a", 5, 10, 20), layers: [layerOf("b", "b", 1, 9, 9)] };
    const changed = (change: Partial<Piece>) => withPiece([piece], piece.key, change)[0];
    expect([changed({ first: -3 })!.first, changed({ last: 99 })!.last]).toEqual([1, 20]);
    expect(sizeOf(changed({ first: 15 })!)).toBe(1);
    expect(changed({ last: 2 })).toMatchObject({ first: 5, last: 5 });
    expect([
      changed({ speed: 0 })!.speed,
      changed({ speed: 99 })!.speed,
      changed({ speed: Number.NaN })!.speed,
    ]).toEqual([0.05, 20, 1]);
    expect(changed({ transition: -1 })!.transition).toBe(0);
    const layer = (change: object) => itemAt(withLayer([piece], itemAt(piece.layers, 0).key, change), 0).layers[0];
    expect([
      layer({ at: 99 })!.at,
      layer({ at: -1 })!.at,
      layer({ strength: 3 })!.strength,
      layer({ ease: -1 })!.ease,
    ]).toEqual([6, 1, 1, 0]);
    expect(itemAt(withoutLayer([piece], itemAt(piece.layers, 0).key), 0).layers).toEqual([]);
  });

  it("learn what their clips are called and how long they are", () => {
    const pieces = withLayers(parsePieces("a:3-99,b"), "1:1:1:0::b");
    const known = learnt(pieces, (document) => ({ name: document.toUpperCase(), frames: 9, bones: ["arm"] }));
    expect(known.map(({ name, first, last }) => [name, first, last])).toEqual([
      ["A", 3, 9],
      ["B", 1, 9],
    ]);
    expect(itemAt(known, 0).layers[0]).toMatchObject({ name: "B", last: 9, bones: ["arm"] });
    expect(learnt(known, () => undefined)).toBe(known);
  });

  it("are asked for with what they say; the first has no seam, and layers without bones are none", () => {
    const [a, b] = withLayers(
      parsePieces("a:1-5_t3_c,b:2-4_x2_m_t0_b"),
      "2:1:0.5:2:arm:c:1-2,2:9:1:0:arm:c:1-2,2:1:1:0::c:1-2",
    );
    expect(asSegments([a!, b!])).toEqual([
      { document: "a", first: 1, last: 5, speed: 1, mirror: false, transition: null, style: null, layers: [] },
      {
        document: "b",
        first: 2,
        last: 4,
        speed: 2,
        mirror: true,
        transition: 0,
        style: "bridge",
        layers: [{ document: "c", first: 1, last: 2, at: 1, bones: ["arm"], strength: 0.5, ease: 2 }],
      },
    ]);
  });
});

describe("edges", () => {
  it("snap to named stretches within reach: to have one, or to go round it", () => {
    const spans = [
      { name: "walk", first: 10, last: 20 },
      { name: "turn", first: 40, last: 50 },
    ];
    expect(snapped(8, "first", spans, 3)).toEqual({ frame: 10, name: "walk" });
    expect(snapped(22, "first", spans, 3)).toEqual({ frame: 21, name: "walk" });
    expect(snapped(18, "last", spans, 3)).toEqual({ frame: 20, name: "walk" });
    expect(snapped(37, "last", spans, 3)).toEqual({ frame: 39, name: "turn" });
    expect(snapped(30, "last", spans, 3)).toEqual({ frame: 30, name: null });
    expect(snapped(8, "first", spans, 0)).toEqual({ frame: 8, name: null });
  });
});
