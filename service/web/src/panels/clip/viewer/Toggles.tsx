/** Switches of what the viewer draws. */
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";
import { clipActions, shown } from "../actions";
import { BodyChoice } from "./BodyChoice";
import { restShown } from "./restPose";

const ALWAYS = ["follow", "ghosts", "trails", "names", "axes"] as const;

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
      <Switch name="body" />
      {!clip.skeleton.view.markers && <BodyChoice clip={clip} />}
      {[...ALWAYS, ...(hasPlates ? (["forces"] as const) : []), "rest" as const].map((one) => (
        <Switch key={one} name={one} />
      ))}
    </>
  );
}

function Switch({ name }: { name: keyof typeof WORDS }) {
  return (
    <button
      type="button"
      class="button quiet dense"
      aria-pressed={name === "rest" ? restShown() : shown.value[name]}
      title={HELP[name] && w(HELP[name])}
      onClick={() => clipActions.toggle(name)}
    >
      {w(WORDS[name])}
    </button>
  );
}
