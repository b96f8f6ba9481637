/** Switches of what the viewer draws besides the body. */
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { clipActions, shown } from "../actions";
import { restShown } from "./restPose";

const ALWAYS = ["follow", "ghosts", "trails", "names", "axes"] as const;

export function Toggles({ clip }: { clip: Clip }) {
  const hasPlates = clip.skeleton.view.plates.length > 0;
  return (
    <>
      {[...ALWAYS, ...(hasPlates ? (["forces"] as const) : []), "rest" as const].map((one) => (
        <button
          key={one}
          type="button"
          class="button quiet dense"
          aria-pressed={one === "rest" ? restShown() : shown.value[one]}
          title={one === "forces" ? w("help.forcesHelp") : undefined}
          onClick={() => clipActions.toggle(one)}
        >
          {w(one === "names" ? "label.jointNames" : one === "rest" ? "label.restPose" : `label.${one}`)}
        </button>
      ))}
    </>
  );
}
