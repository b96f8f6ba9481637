/** The storyboard that is open: its steps, what of it is chosen, and what can be done with it. */
import { itemAt } from "../../lists";
import { computed, signal } from "@preact/signals";
import {
  learnt,
  layerOf,
  movePiece,
  pieceOf,
  readBoard,
  splitPiece,
  withLayer,
  withoutLayer,
  withPiece,
  writeBoard,
  type Layer,
  type Piece,
  type Storyboard,
} from "../../state/editing/composition";
import { param } from "../../state/session/route";
import { kept } from "../../state/session/settings";
import { Steps } from "../../state/editing/steps";
import { w } from "../../words";
import { facts } from "./facts";

/** The storyboard of the last visit, as its address had it. */
export const draft = kept<string>("storyboard", "");
const DRAG = "application/x-mcml-clip";

/** Frames of a clip that are dragged or added. */
export interface Taken {
  id: string;
  name: string;
  first?: number;
  last?: number;
}
export type Chosen = { kind: "piece" | "seam" | "layer"; key: number } | null;

export class Board {
  readonly steps: Steps<Storyboard>;
  readonly chosen = signal<Chosen>(null);
  /** The frame (from 0) of its own clip that the piece under the playhead shows, and which piece. */
  readonly place = signal<{ index: number; frame: number; share: number } | null>(null);
  readonly pieces = computed(() => this.steps.now.value.pieces);
  /** What is chosen, wherever undo brought it; else the first piece. */
  readonly at = computed(() => {
    const pieces = this.pieces.value;
    const wanted = this.chosen.value;
    for (const [index, piece] of wanted?.kind === "layer" ? pieces.entries() : []) {
      const layer = piece.layers.find((one) => one.key === wanted?.key);
      if (layer) return { kind: "layer" as const, index, piece, layer };
    }
    const found = wanted ? pieces.findIndex((one) => one.key === wanted.key) : -1;
    const index = Math.max(0, found);
    const piece = pieces[index];
    if (!piece) return null;
    return {
      kind: wanted?.kind === "seam" && index > 0 ? ("seam" as const) : ("piece" as const),
      index,
      piece,
      layer: null,
    };
  });

  /** From the address; else from the last visit. What was in work before is one step back. */
  constructor() {
    const before = readBoard((name) => new URLSearchParams(draft.peek()).get(name) ?? "", w("label.untitled"));
    const asked = readBoard(param, w("label.untitled"));
    const same = writeBoard(asked, "").s === writeBoard(before, "").s;
    if (!asked.pieces.length) this.steps = new Steps(before);
    else this.steps = new Steps(asked, before.pieces.length && !same ? [before] : []);
  }

  private set(change: Partial<Storyboard>, kind = ""): void {
    this.steps.set({ ...this.steps.now.peek(), ...change }, kind);
  }

  get written(): Record<string, string | null> {
    return writeBoard(this.steps.now.value, w("label.untitled"));
  }

  learn(): void {
    const now = this.steps.now.peek();
    const pieces = learnt(now.pieces, (document) => facts.peek().get(document));
    if (pieces !== now.pieces) this.steps.amend({ ...now, pieces });
  }

  rename = (name: string) => this.set({ name }, "name");
  setAll = (change: Partial<Pick<Storyboard, "seconds" | "transition" | "style" | "lockFeet" | "matchPhase">>) =>
    this.set(change, Object.keys(change)[0]);
  setPiece = (key: number, change: Partial<Piece>, kind = "") =>
    this.set({ pieces: withPiece(this.pieces.peek(), key, change) }, kind && `${kind} ${key}`);
  setLayer = (key: number, change: Partial<Layer>, kind = "") =>
    this.set({ pieces: withLayer(this.pieces.peek(), key, change) }, kind && `${kind} ${key}`);

  add = (taken: readonly Taken[], at = this.pieces.peek().length) => {
    const made = taken.map(({ id, name, first = 1, last = 0 }) => pieceOf(id, name, first, last));
    if (!made.length) return;
    this.set({ pieces: this.pieces.peek().toSpliced(at, 0, ...made) });
    this.chosen.value = { kind: "piece", key: itemAt(made, 0).key };
    this.learn();
  };

  addLayer = (taken: Taken, index = this.at.peek()?.index ?? 0, at = 1) => {
    const pieces = this.pieces.peek();
    if (!pieces[index]) return;
    const layer = { ...layerOf(taken.id, taken.name, taken.first, taken.last), at };
    this.set({
      pieces: pieces.map((one, place) => (place === index ? { ...one, layers: [...one.layers, layer] } : one)),
    });
    this.chosen.value = { kind: "layer", key: layer.key };
    this.learn();
  };

  move = (by: number) => {
    const here = this.at.peek();
    if (here) this.moveTo(here.index, here.index + by);
  };

  moveTo = (from: number, to: number) => {
    const pieces = this.pieces.peek();
    if (to < 0 || to >= pieces.length || to === from) return;
    this.chosen.value = { kind: "piece", key: itemAt(pieces, from).key };
    this.set({ pieces: movePiece(pieces, from, to) });
  };

  split = () => {
    const place = this.place.peek();
    const pieces = this.pieces.peek();
    const made = place ? splitPiece(pieces, place.index, place.frame + 1) : pieces;
    if (made.length > pieces.length) this.set({ pieces: made });
  };

  remove = () => {
    const here = this.at.peek();
    if (!here) return;
    const pieces = this.pieces.peek();
    if (here.kind === "layer") {
      this.set({ pieces: withoutLayer(pieces, here.layer.key) });
      this.chosen.value = { kind: "piece", key: here.piece.key };
    } else {
      this.set({ pieces: pieces.filter((one) => one !== here.piece) });
      const next = this.pieces.peek()[Math.max(0, here.index - 1)];
      this.chosen.value = next ? { kind: "piece", key: next.key } : null;
    }
  };

  clear = () => this.set({ pieces: [], name: w("label.untitled") });
}

export const carry = (event: DragEvent, taken: readonly Taken[]): void =>
  event.dataTransfer?.setData(DRAG, JSON.stringify(taken));

export function carried(event: DragEvent): Taken[] {
  const text = event.dataTransfer?.getData(DRAG);
  if (!text) return [];
  event.preventDefault();
  event.stopPropagation();
  return JSON.parse(text) as Taken[];
}
