/** The composition as it will move: the server makes its positions without storing anything. */
import { signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { previewOf } from "../../motion/preview";
import { Player } from "../../state/player";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/MotionView";
import { w } from "../../words";
import { Scrubber } from "../../ui/Scrubber";
import type { Composed } from "./ComposerPage";

export function ComposedView({ composed, selected, onPlace }: {
  composed: Composed;
  selected: number;
  /** The frame (from 0) of its own clip that the selected piece shows. */
  onPlace: (frame: number) => void;
}) {
  const preview = useMemo(() => (composed.motion ? previewOf(composed.motion, composed.skeleton, composed.frames, 1 / composed.seconds_per_frame, composed.step) : null), [composed]);
  const frame = useMemo(() => signal(0), []);
  const player = useMemo(() => new Player(composed.frames, 1 / composed.seconds_per_frame), [composed]);
  const spans = composed.segments;

  useEffect(() => {
    player.seek(Math.min(frame.peek(), composed.frames - 1));
    const stop = player.frame.subscribe((now) => {
      frame.value = now;
      const here = spans.find((one) => now + 1 >= one.first && now + 1 <= one.last);
      if (here) onPlace(here.source_first - 1 + now + 1 - here.first);
    });
    return () => { stop(); player.pause(); };
  }, [player]);
  // The piece that is picked is gone to.
  useEffect(() => {
    const span = spans.find((one) => one.segment === selected + 1);
    if (span && !player.playing.peek()) player.seek(span.first - 1);
  }, [selected]);
  const actors = useMemo<Actor[]>(() => (preview ? [{ skeleton: preview.skeleton, positions: () => preview.frame(frame.value) }] : []), [preview]);
  const bands = useMemo(() => [
    ...spans.map((one) => ({ from: one.first - 1, to: one.last, ink: one.segment === selected + 1 ? "select" : "accent", alpha: one.segment === selected + 1 ? 0.35 : 0.16 })),
  ], [composed, selected]);
  return (
    <div class="composed-view">
      <MotionView actors={actors} label={w("previewWord")} />
      <div class="transport row">
        <button type="button" class="button quiet icon play" aria-label={w(player.playing.value ? "pause" : "play")} onClick={() => player.toggle()}><Icon name={player.playing.value ? "pause" : "play"} /></button>
        <Scrubber player={player} bands={bands} />
      </div>
    </div>
  );
}
