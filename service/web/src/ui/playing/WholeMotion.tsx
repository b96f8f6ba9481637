/** A motion that is not stored, told as a whole: it plays. */
import { useEffect, useMemo } from "preact/hooks";
import type { Preview } from "../../motion/loading/preview";
import { Player } from "../../state/clip/player";
import { MotionView, type Actor } from "./MotionView";
import { PlayBar } from "./PlayBar";

export function WholeMotion({ motion, label, className }: { motion: Preview; label: string; className: string }) {
  const player = useMemo(() => new Player(motion.frames, motion.perSecond), [motion]);
  const actors = useMemo<Actor[]>(
    () => [{ skeleton: motion.skeleton, positions: () => motion.frame(player.frame.value) }],
    [motion],
  );
  useEffect(() => {
    player.play(1);
    return () => player.pause();
  }, [player]);
  return (
    <div class={className}>
      <MotionView actors={actors} label={label} />
      <PlayBar player={player} />
    </div>
  );
}
