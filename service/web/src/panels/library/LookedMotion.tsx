/** The motion of a file that is not stored. */
import { useEffect, useMemo } from "preact/hooks";
import { numbersOf, wholeOf, type Told } from "../../motion/preview";
import { Player } from "../../state/player";
import { MotionView, type Actor } from "../../ui/MotionView";
import { PlayBar } from "../../ui/PlayBar";
import { w } from "../../words";

export function LookedMotion({ told }: { told: Told }) {
  const preview = useMemo(() => wholeOf(told, numbersOf(told)), [told]);
  const player = useMemo(() => new Player(preview.frames, preview.perSecond), [preview]);
  const actors = useMemo<Actor[]>(() => [{ skeleton: preview.skeleton, positions: () => preview.frame(player.frame.value) }], [preview]);
  useEffect(() => {
    player.play(1);
    return () => player.pause();
  }, [player]);
  return (
    <div class="looked-motion">
      <MotionView actors={actors} label={w("previewWord")} />
      <PlayBar player={player} />
    </div>
  );
}
