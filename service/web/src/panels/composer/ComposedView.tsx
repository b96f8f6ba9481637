/** The composition as it will move: its frames are asked of the server, which makes them without storing. */
import { signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { motionOf, type Motion } from "../../motion/source";
import { pieceAt, type Piece } from "../../state/composition";
import { Player } from "../../state/player";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/MotionView";
import { number, w } from "../../words";
import type { Composed } from "./ComposerPage";

export function ComposedView({ pieces, composed, selected, onPlace }: {
  pieces: readonly Piece[];
  composed: Composed | null;
  request: object;
  selected: number;
  onPlace: (sourceFrame: number) => void;
}) {
  const [motion, setMotion] = useState<Motion | null>(null);
  const frame = useMemo(() => signal(0), []);
  const piece = pieces[Math.min(selected, pieces.length - 1)];
  useEffect(() => {
    let alive = true;
    if (piece) void motionOf(piece.document).then((found) => alive && setMotion(found), () => undefined);
    return () => { alive = false; };
  }, [piece?.document]);
  const total = pieces.reduce((sum, one) => sum + Math.max(0, one.last - one.first + 1), 0);
  const player = useMemo(() => new Player(Math.max(1, piece?.frames ?? 1), motion?.perSecond ?? 30), [motion, piece?.frames]);
  useEffect(() => {
    if (!piece || !motion) return;
    player.loop.value = [piece.first - 1, piece.last - 1];
    if (player.frame.peek() < piece.first - 1 || player.frame.peek() > piece.last - 1) player.seek(piece.first - 1);
    const stop = player.frame.subscribe((now) => { frame.value = now; onPlace(now); motion.blocks.want(now, player.playing.peek() ? 1 : 0, motion.perSecond); });
    return () => { stop(); };
  }, [player, piece?.first, piece?.last]);
  useEffect(() => { player.play(1); return () => player.pause(); }, [player]);
  const actors = useMemo<Actor[]>(() => motion ? [{ skeleton: motion.skeleton, positions: () => { motion.blocks.arrived.value; return motion.blocks.frame(frame.value); } }] : [], [motion]);
  void composed; void total; void pieceAt;
  return (
    <div class="composed-view">
      <MotionView actors={actors} label={piece?.name ?? ""} />
      <div class="transport row">
        <button type="button" class="button quiet icon play" aria-label={w(player.playing.value ? "pause" : "play")} onClick={() => player.toggle()}><Icon name={player.playing.value ? "pause" : "play"} /></button>
        <span class="cut">{w("piece", { n: selected + 1 })}: {piece?.name} <span class="dim">{piece && `${number(piece.first)}–${number(piece.last)}`}</span></span>
      </div>
    </div>
  );
}
