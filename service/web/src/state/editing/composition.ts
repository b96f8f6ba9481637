/** A storyboard: pieces of stored clips in an order, transitions between them, layers upon them. Kept in the address. */
export type Style = "bridge" | "crossfade" | "inertial";

/** Frames of another clip that some bones of a piece move by. */
export interface Layer {
  key: number;
  document: string;
  name: string;
  /** Positions from 1, both included; last 0: to the end of a clip whose frames are not known yet. */
  first: number;
  last: number;
  frames: number;
  /** Frame of the piece, from 1, where it begins. */
  at: number;
  /** None: not chosen yet. */
  bones: readonly string[];
  /** 0 to 1. */
  strength: number;
  /** Frames over which it comes and goes. */
  ease: number;
}

export interface Piece {
  key: number;
  document: string;
  name: string;
  /** As of a layer. */
  first: number;
  last: number;
  /** Frames of the whole clip, once it is known. */
  frames: number;
  speed: number;
  mirror: boolean;
  /** Of the transition before it; null: as all. */
  transition: number | null;
  style: Style | null;
  layers: readonly Layer[];
}

export interface Storyboard {
  name: string;
  pieces: readonly Piece[];
  /** Of all transitions that say nothing else: seconds, or frames where an address states them. */
  seconds: number;
  transition: number | null;
  style: Style;
  /** Whether feet that stand stay in place during transitions. */
  lockFeet: boolean;
  /** Whether walks meet in the same phase of a step: some frames at their ends are left out. */
  matchPhase: boolean;
}

export const USUAL_SECONDS = 0.3;
export const LONGEST_SECONDS = 60;
export const STYLES: readonly Style[] = ["bridge", "crossfade", "inertial"];
export const [SLOWEST, FASTEST, LONGEST] = [0.05, 20, 2000]; // what a composition takes
const PLACES = 1000; // of strength and speed in an address

let lastKey = 0;
export const pieceOf = (document: string, name = "", first = 1, last = 0, frames = 0): Piece => ({
  key: ++lastKey,
  document,
  name,
  first,
  last,
  frames,
  speed: 1,
  mirror: false,
  transition: null,
  style: null,
  layers: [],
});
export const layerOf = (document: string, name = "", first = 1, last = 0, frames = 0): Layer => ({
  key: ++lastKey,
  document,
  name,
  first,
  last,
  frames,
  at: 1,
  bones: [],
  strength: 1,
  ease: 8,
});
export const sizeOf = (one: Pick<Piece, "first" | "last">): number => Math.max(0, one.last - one.first + 1);

const rangeOf = ({ document, first, last, frames }: Pick<Piece, "document" | "first" | "last" | "frames">): string =>
  first === 1 && (!last || last === frames) ? document : `${document}:${first}-${last || ""}`;
const short = (value: number): string => String(Math.round(value * PLACES) / PLACES);

/** Change a piece by a part of an address such as "x2"; parts that say nothing of a piece change nothing. */
function applyOption(piece: Piece, option: string): void {
  const value = Number(option.slice(1));
  if (option === "m") piece.mirror = true;
  else if (STYLES.some((one) => one[0] === option)) piece.style = STYLES.find((one) => one[0] === option) ?? null;
  else if (option.startsWith("x") && value >= SLOWEST && value <= FASTEST) piece.speed = value;
  else if (option.startsWith("t") && value >= 0 && value <= LONGEST) piece.transition = Math.round(value);
}

/** "id:first-last_x2_m_t8_c,id" as an address has it: speed, mirrored, transition, first letter of its style. */
export function parsePieces(text: string): Piece[] {
  return text
    .split(",")
    .filter(Boolean)
    .map((part) => {
      const [where = "", ...options] = part.split("_");
      const [document = "", range = ""] = where.split(":");
      const [first, last] = range.split("-").map(Number);
      const piece = pieceOf(document, "", first || 1, last || 0);
      for (const option of options) applyOption(piece, option);
      return piece;
    });
}

/** Of a whole clip, or one whose frames are not known yet, no range is written. */
export const writePieces = (pieces: readonly Piece[]): string =>
  pieces
    .map((piece) =>
      [
        rangeOf(piece),
        ...(piece.speed === 1 ? [] : [`x${short(piece.speed)}`]),
        ...(piece.mirror ? ["m"] : []),
        ...(piece.transition === null ? [] : [`t${piece.transition}`]),
        ...(piece.style === null ? [] : [piece.style[0]]),
      ].join("_"),
    )
    .join(",");

/** "piece:at:strength:ease:bone+bone:id:first-last", pieces from 1. */
export const writeLayers = (pieces: readonly Piece[]): string =>
  pieces
    .flatMap((piece, index) =>
      piece.layers.map((one) =>
        [
          index + 1,
          one.at,
          short(one.strength),
          one.ease,
          one.bones.map(encodeURIComponent).join("+"),
          rangeOf(one),
        ].join(":"),
      ),
    )
    .join(",");

/** Pieces with the layers that an address names. */
export function withLayers(pieces: readonly Piece[], text: string): Piece[] {
  const found = text
    .split(",")
    .filter(Boolean)
    .map((part) => part.split(":"));
  return pieces.map((piece, index) => ({
    ...piece,
    layers: found
      .filter(([place, , , , , document]) => Number(place) === index + 1 && document)
      .map(([, at, strength, ease, bones = "", document = "", range = ""]) => {
        const [first, last] = range.split("-").map(Number);
        return {
          ...layerOf(document, "", first || 1, last || 0),
          at: Math.max(1, Number(at) || 1),
          strength: Math.min(1, Math.max(0, Number(strength))) || 0,
          ease: Math.max(0, Number(ease) || 0),
          bones: bones.split("+").filter(Boolean).map(decodeURIComponent),
        };
      }),
  }));
}

export const heldSeconds = (value: number): number => Math.min(LONGEST_SECONDS, Math.max(0, value || 0));

/** What the repository is asked to compose. */
export const asRequest = ({ pieces, seconds, transition, style, lockFeet, matchPhase }: Storyboard) => ({
  segments: asSegments(pieces),
  ...(transition === null ? { seconds } : { transition }),
  style,
  lock_feet: lockFeet,
  match_phase: matchPhase,
});

/** As an address has it; null takes a parameter away. */
export const writeBoard = (
  { name, pieces, seconds, transition, style, lockFeet, matchPhase }: Storyboard,
  usualName: string,
): Record<"s" | "l" | "t" | "seconds" | "style" | "feet" | "phase" | "name", string | null> => ({
  s: writePieces(pieces) || null,
  l: writeLayers(pieces) || null,
  t: transition === null ? null : String(transition),
  seconds: seconds === USUAL_SECONDS ? null : short(seconds),
  feet: lockFeet ? null : "free",
  phase: matchPhase ? "match" : null,
  style: style === "bridge" ? null : style,
  name: name === usualName ? null : name,
});

export const readBoard = (param: (name: string) => string, usualName: string): Storyboard => ({
  name: param("name") || usualName,
  pieces: withLayers(parsePieces(param("s")), param("l")),
  transition: param("t") ? Math.min(LONGEST, Math.max(0, Math.round(Number(param("t")) || 0))) : null,
  seconds: param("seconds") ? heldSeconds(Number(param("seconds"))) : USUAL_SECONDS,
  style: STYLES.find((one) => one === param("style")) ?? "bridge",
  lockFeet: param("feet") !== "free",
  matchPhase: param("phase") === "match",
});

/** What the repository is asked to make. What is as usual is not said: frames that follow one another stay so. */
export const asSegments = (pieces: readonly Piece[]) =>
  pieces.map((one, index) => ({
    document: one.document,
    first: one.first,
    last: one.last,
    speed: one.speed,
    mirror: one.mirror,
    transition: index ? one.transition : null,
    style: index ? one.style : null,
    layers: one.layers
      .filter((layer) => layer.bones.length && layer.at <= sizeOf(one))
      .map(({ document, first, last, at, bones, strength, ease }) => ({
        document,
        first,
        last,
        at,
        bones: [...bones],
        strength,
        ease,
      })),
  }));

/** Change one piece, held within its clip and what a composition takes. */
export const withPiece = (pieces: readonly Piece[], key: number, change: Partial<Piece>): Piece[] =>
  pieces.map((piece) => {
    if (piece.key !== key) return piece;
    const one = { ...piece, ...change };
    const speed = Number.isFinite(one.speed) ? Math.min(FASTEST, Math.max(SLOWEST, one.speed)) : piece.speed;
    return {
      ...one,
      ...held(one, piece),
      speed,
      transition: one.transition === null ? null : Math.round(Math.min(LONGEST, Math.max(0, one.transition))),
    };
  });

export const withLayer = (pieces: readonly Piece[], key: number, change: Partial<Layer>): Piece[] =>
  pieces.map((piece) =>
    piece.layers.some((one) => one.key === key)
      ? {
          ...piece,
          layers: piece.layers.map((layer) => {
            if (layer.key !== key) return layer;
            const one = { ...layer, ...change };
            return {
              ...one,
              ...held(one, layer),
              at: Math.max(1, Math.min(piece.last ? sizeOf(piece) : one.at, Math.round(one.at) || 1)),
              strength: Math.min(1, Math.max(0, one.strength)),
              ease: Math.max(0, Math.round(one.ease) || 0),
            };
          }),
        }
      : piece,
  );

/** A range inside its clip; the edge that was not moved stays. */
function held(
  one: Pick<Piece, "first" | "last" | "frames">,
  before: Pick<Piece, "first" | "last">,
): { first: number; last: number } {
  const most = one.frames || Math.max(one.last, one.first);
  let first = Math.round(Math.min(most, Math.max(1, one.first || 1)));
  let last = one.last && Math.round(Math.min(most, Math.max(1, one.last)));
  if (last && first > last) {
    if (one.first !== before.first) first = last;
    else last = first;
  }
  return { first, last };
}

export const withoutLayer = (pieces: readonly Piece[], key: number): Piece[] =>
  pieces.map((piece) =>
    piece.layers.some((one) => one.key === key)
      ? { ...piece, layers: piece.layers.filter((one) => one.key !== key) }
      : piece,
  );

/** What became known of the clips; the same list where nothing is new. */
export function learnt(
  pieces: readonly Piece[],
  of: (document: string) => { name: string; frames: number; bones: readonly string[] } | undefined,
): readonly Piece[] {
  let any = false;
  const fill = <T extends Piece | Layer>(one: T): T => {
    const known = one.frames ? undefined : of(one.document);
    if (!known) return one;
    any = true;
    const last = Math.min(one.last || known.frames, known.frames);
    return { ...one, name: known.name, frames: known.frames, last, first: Math.min(one.first, last) };
  };
  const first = pieces[0] && of(pieces[0].document);
  const found = pieces.map((piece) => {
    const one = fill(piece);
    return {
      ...one,
      layers: one.layers.map((layer) => {
        const full = fill(layer);
        if (full.bones.length || !first) return full;
        any = true;
        return { ...full, bones: first.bones };
      }),
    };
  });
  return any ? found : pieces;
}

/** Cut a piece before a frame; unchanged where the frame is no inner one. Layers go with the part that they are on. */
export function splitPiece(pieces: readonly Piece[], index: number, frame: number): Piece[] {
  const piece = pieces[index];
  if (!piece || frame <= piece.first || frame > piece.last) return [...pieces];
  const cut = frame - piece.first; // frames of the first part
  const before = piece.layers.filter((one) => one.at <= cut);
  const after = piece.layers.filter((one) => one.at > cut).map((one) => ({ ...one, at: one.at - cut }));
  return pieces.flatMap((one, at) =>
    at === index
      ? [
          { ...one, last: frame - 1, layers: before },
          { ...one, key: ++lastKey, first: frame, transition: null, style: null, layers: after },
        ]
      : [one],
  );
}

export function movePiece(pieces: readonly Piece[], from: number, to: number): Piece[] {
  const next = [...pieces];
  const moved = next.splice(from, 1);
  next.splice(Math.max(0, Math.min(next.length, to)), 0, ...moved);
  return next;
}

export interface Stretch {
  name: string;
  first: number;
  last: number;
}

/** The frame to which an edge goes: the nearest edge of a named stretch within `reach` frames, or where it is. */
export function snapped(
  frame: number,
  edge: "first" | "last",
  spans: readonly Stretch[],
  reach: number,
): { frame: number; name: string | null } {
  let best: { frame: number; name: string | null } = { frame, name: null };
  let least = reach + 1e-9;
  for (const { name, first, last } of spans) {
    // A piece may have the stretch, or end before it and begin after it.
    for (const place of edge === "first" ? [first, last + 1] : [last, first - 1]) {
      const away = Math.abs(place - frame);
      if (away < least) [best, least] = [{ frame: place, name }, away];
    }
  }
  return best;
}
