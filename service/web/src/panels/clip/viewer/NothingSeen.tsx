/** Says that a frame shows nothing, as the first ones of a marker trial may, and leads to a frame that does. */
import { useComputed } from "@preact/signals";
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { r } from "../words";
import { nearestSeen } from "./seen";

export function NothingSeen({ clip }: { clip: Clip }) {
  const nearest = useComputed(() => {
    clip.blocks.arrived.value;
    const frame = clip.player.frame.value;
    const positions = clip.blocks.has(frame) ? clip.positions(frame, false) : null;
    return nearestSeen(positions, clip.blocks.overview(), frame, clip.skeleton.points);
  }).value;
  if (nearest === null) return null;
  return (
    <p class="why-sticks nothing-seen" role="status">
      {r("help.nothingSeen")}{" "}
      {nearest >= 0 && (
        <button type="button" class="button dense" onClick={() => clip.player.seek(nearest)}>
          {w("button.goToFrame", { n: nearest + 1 })}
        </button>
      )}
    </p>
  );
}
