/** Switches of what the viewer draws. */
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { clipActions, shown } from "../actions";
import { restShown } from "./restPose";

const ALWAYS = ["body", "follow", "ghosts", "trails", "names", "axes"] as const;

const WORDS = {
  body: "label.bodyShown",
  follow: "label.follow",
  ghosts: "label.ghosts",
  trails: "label.trails",
  names: "label.jointNames",
  axes: "label.axes",
  forces: "label.forces",
  rest: "label.restPose",
} as const;
const HELP: Partial<Record<keyof typeof WORDS, "help.forcesHelp" | "help.bodyHelp">> = {
  forces: "help.forcesHelp",
  body: "help.bodyHelp",
};

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
          title={HELP[one] && w(HELP[one])}
          onClick={() => clipActions.toggle(one)}
        >
          {w(WORDS[one])}
        </button>
      ))}
    </>
  );
}
