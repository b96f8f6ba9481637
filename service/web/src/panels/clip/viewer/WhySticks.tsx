/** Why a clip is drawn as sticks where bodies are wanted, or what its character leaves out. */
import { characterOf } from "../../../motion/loading/character";
import { chosenCharacter } from "../../../state/clip/characters";
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { shown } from "../actions";
import { r } from "../words";
import { isRedrawn } from "./poses";

export function WhySticks({ clip }: { clip: Clip }) {
  const { id, detail, skeleton } = clip;
  if (!shown.value.body) return null;
  const body = characterOf({ id, revision: detail.revision, skeleton }, chosenCharacter.value).value;
  if (!body) return null;
  const reason = body.reason || (body.frames && isRedrawn(clip) ? r("help.draftAsSticks") : "");
  if (reason)
    return (
      <p class="why-sticks" role="status">
        <strong>{w("help.noBody")}</strong> {reason}
      </p>
    );
  return null;
}
