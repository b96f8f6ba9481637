/** The motion of a file that is not stored. */
import { useEffect, useMemo } from "preact/hooks";
import { bodyOf, previewOf, type Told } from "../../motion/preview";
import { Player } from "../../state/player";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/MotionView";
import { Scrubber } from "../../ui/Scrubber";
import { w } from "../../words";

const USUAL_RATE = 30;

export function LookedMotion({ told }: { told: Told }) {
  const frames = told.shape[0];
  const preview = useMemo(() => previewOf(told, bodyOf(told, frames), frames, 1 / (told.seconds_per_frame || 1 / USUAL_RATE), 1), [told]);
  const player = useMemo(() => new Player(frames, preview.perSecond), [preview]);
  const actors = useMemo<Actor[]>(() => [{ skeleton: preview.skeleton, positions: () => preview.frame(player.frame.value) }], [preview]);
  useEffect(() => {
    player.play(1);
    return () => player.pause();
  }, [player]);
  return (
    <div class="looked-motion">
      <MotionView actors={actors} label={w("previewWord")} />
      <div class="transport row">
        <button type="button" class="button quiet icon play" aria-label={w(player.playing.value ? "pause" : "play")} onClick={() => player.toggle()}><Icon name={player.playing.value ? "pause" : "play"} /></button>
        <Scrubber player={player} />
      </div>
    </div>
  );
}
