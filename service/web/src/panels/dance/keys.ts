/** Keys of the bench: what a pointer does on a clip's row, and the beat of the tempo. */
import { signal } from "@preact/signals";
import { tapped, tempoOf } from "../../motion/dance/tempo";
import type { Command } from "../../state/session/keys";
import { param, setParams } from "../../state/session/route";
import type { Bench } from "./bench";

/** Taps of the tempo so far, ms. */
export const taps = signal<number[]>([]);

/** One more tap: the tempo of the last ones is that of the dance. */
export function tap(now = performance.now()): void {
  taps.value = tapped(taps.peek(), now);
  const bpm = tempoOf(taps.peek());
  if (bpm) setParams({ bpm: String(Math.round(Math.min(240, Math.max(40, bpm)) * 10) / 10) });
}

/** Seconds of the sound at which the dance begins, moved. */
export const moveOffset = (by: number): void => setOffset(offsetNow() + by);
export const offsetNow = (): number => Number(param("offset")) || 0;
export const setOffset = (to: number): void =>
  setParams({ offset: Math.abs(to) < 0.0005 ? null : String(Math.round(to * 1000) / 1000) });

export function keysOf(bench: Bench): Command[] {
  const here = () => bench.row(bench.clip.peek());
  return [
    {
      id: "play",
      word: "button.play",
      keys: ["Space"],
      run: () => bench.player.peek()?.toggle(),
      when: () => bench.player.peek() !== null,
    },
    { id: "undo", word: "button.undo", keys: ["Ctrl+Z"], run: () => bench.steps.undo() },
    { id: "redo", word: "button.redo", keys: ["Ctrl+Shift+Z", "Ctrl+Y"], run: () => bench.steps.redo() },
    {
      id: "beat",
      word: "button.addBeat",
      keys: ["B"],
      run: () => bench.addBeat(bench.clip.peek(), bench.at.peek()),
      when: () => here() !== undefined,
    },
    {
      id: "accept",
      word: "button.acceptTracked",
      keys: ["Shift+B"],
      run: () => bench.accept(bench.clip.peek()),
      when: () => here() !== undefined,
    },
    {
      id: "delete",
      word: "button.remove",
      keys: ["Del", "Backspace"],
      run: () => bench.removeBeat(bench.clip.peek(), bench.beat.peek()),
      when: () => (here()?.beats.length ?? 0) > bench.beat.peek() && bench.beat.peek() >= 0,
    },
    { id: "tap", word: "label.tapTempo", keys: ["T"], run: () => tap() },
    { id: "earlier", word: "label.soundEarlier", keys: ["Shift+,"], run: () => moveOffset(-0.01) },
    { id: "later", word: "label.soundLater", keys: ["Shift+."], run: () => moveOffset(0.01) },
  ];
}
