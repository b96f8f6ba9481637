/** The composition as it will move: the server makes its positions without storing anything. */
import { signal, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { previewOf } from "../../motion/loading/preview";
import { Player } from "../../state/clip/player";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { Scrubber } from "../../ui/playing/Scrubber";
import { w } from "../../words";
import type { Board } from "./board";
import { facts } from "./facts";
import { toggleBone } from "./Forms";
import { isRough, type Composed } from "./seams";

const AROUND = 0.75; // seconds before a seam that is looked at

export function ComposedView({ composed, board }: { composed: Composed; board: Board }) {
  const preview = useMemo(
    () =>
      composed.motion
        ? previewOf(composed.motion, composed.skeleton, composed.frames, 1 / composed.seconds_per_frame, composed.step)
        : null,
    [composed],
  );
  const frame = useMemo(() => signal(0), []);
  const plays = useMemo(() => ({ now: false }), []);
  const player = useMemo(() => new Player(composed.frames, 1 / composed.seconds_per_frame), [composed]);
  const spans = composed.segments;
  const here = board.at.value;
  const shown = useSignal(preview);
  shown.value = preview;

  useEffect(() => {
    player.seek(Math.min(frame.peek(), composed.frames - 1));
    const stop = player.frame.subscribe((now) => {
      frame.value = now;
      board.place.value = placeIn(now);
    });
    if (plays.now) player.play(1);
    const stopPlays = player.playing.subscribe((now) => (plays.now = now));
    return () => {
      const before = plays.now;
      stop();
      stopPlays();
      player.pause();
      plays.now = before; // Another preview goes on where this one was.
    };
  }, [player]);
  const placeIn = (now: number) => {
    const span = spans.find((one) => now + 1 >= one.first && now + 1 <= one.last);
    const index = span ? span.segment - 1 : -1;
    const piece = board.pieces.peek()[index];
    if (!span || !piece) return null;
    const source = facts.peek().get(piece.document)?.perSecond ?? 1 / composed.seconds_per_frame;
    const at = Math.round((now + 1 - span.first) * composed.seconds_per_frame * source * piece.speed);
    const size = Math.max(1, piece.last - piece.first + 1);
    return {
      index,
      frame: Math.min(piece.last, span.source_first + at) - 1,
      share: Math.min(1, (span.source_first - piece.first + at) / size),
    };
  };
  // What is picked is gone to; a seam, some moments before it.
  const seam = here?.kind === "seam" ? composed.seams.find((one) => one.segment === here.index + 1) : undefined;
  useEffect(() => {
    if (!here || player.playing.peek()) return;
    const now = board.place.peek();
    const span = spans.find((one) => one.segment === here.index + 1);
    if (seam) player.seek(seam.first - 1 - AROUND / composed.seconds_per_frame);
    else if (span && now?.index !== here.index) player.seek(span.first - 1);
  }, [here?.kind, here?.piece.key]);

  const actors = useMemo<Actor[]>(
    () => (preview ? [{ skeleton: preview.skeleton, positions: () => shown.value?.frame(frame.value) ?? null }] : []),
    [preview?.skeleton],
  );
  const marked = useMemo(
    () => ({
      get value() {
        const at = board.at.value;
        return at?.kind === "layer"
          ? at.layer.bones.map((bone) => composed.skeleton.byName.get(bone) ?? -1).filter((one) => one >= 0)
          : [];
      },
    }),
    [composed.skeleton],
  );
  const bands = useMemo(
    () => [
      ...spans.map((one) => ({
        from: one.first - 1,
        to: one.last,
        ink: one.segment - 1 === here?.index ? "select" : "accent",
        alpha: one.segment - 1 === here?.index ? 0.35 : 0.16,
      })),
      ...composed.seams.filter(isRough).map((one) => ({
        from: one.first - 1,
        to: one.first - 1 + Math.max(2, one.transition),
        ink: "warn",
        alpha: 0.6,
      })),
    ],
    [composed, here?.index],
  );
  return (
    <div class="composed-view">
      <MotionView
        actors={actors}
        selected={marked as never}
        label={w("label.previewWord")}
        onPick={(_, point) => {
          const bone = composed.skeleton.view.bones[point]?.name;
          if (here?.kind === "layer" && bone) toggleBone(board, here.layer, bone);
        }}
      />
      <div class="transport row">
        <button
          type="button"
          class="button quiet icon play"
          aria-label={w(player.playing.value ? "button.pause" : "button.play")}
          onClick={() => player.toggle()}
        >
          <Icon name={player.playing.value ? "pause" : "play"} />
        </button>
        <Scrubber player={player} bands={bands} />
      </div>
    </div>
  );
}
