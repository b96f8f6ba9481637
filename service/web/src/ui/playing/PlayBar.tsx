/** Play, and a line of time. */
import type { ComponentChildren } from "preact";
import type { Player } from "../../state/clip/player";
import { w } from "../../words";
import { Icon } from "../icons";
import { Scrubber, type Band } from "./Scrubber";

export function PlayBar({ player, bands, children }: { player: Player; bands?: Band[]; children?: ComponentChildren }) {
  const playing = player.playing.value;
  return (
    <div class="transport row">
      <button
        type="button"
        class="button quiet icon play"
        aria-label={w(playing ? "button.pause" : "button.play")}
        onClick={() => player.toggle()}
      >
        <Icon name={playing ? "pause" : "play"} />
      </button>
      <Scrubber player={player} bands={bands} />
      {children}
    </div>
  );
}
