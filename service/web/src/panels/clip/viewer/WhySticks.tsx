/** Why a clip is drawn as sticks where bodies are wanted. */
import { characterOf } from "../../../motion/loading/character";
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { shown } from "../actions";

export function WhySticks({ clip }: { clip: Clip }) {
  const body = shown.value.body ? characterOf(clip.id, clip.detail.revision).value : null;
  if (!body?.reason) return null;
  return (
    <p class="why-sticks" role="status">
      <strong>{w("help.noBody")}</strong> {body.reason}
    </p>
  );
}
