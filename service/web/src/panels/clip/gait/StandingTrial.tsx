/** The standing trial whose offsets a walking trial has, and the way to take those of another. */
import { useState } from "preact/hooks";
import { get } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { mayEdit } from "../../../state/session/me";
import { refuse } from "../../../state/session/notes";
import { Chooser } from "../../../ui/clips/ClipChooser";
import { StandingTrialDialog } from "../../../ui/gait/StandingTrialDialog";
import { g } from "../../../ui/gait/words";

/** The property that names the standing trial. */
const PROPERTY = /^gait (.+ )?standing trial$/;

interface Chosen {
  id: string;
  name: string;
  trials: readonly string[];
}

/** Of trials of markers; nothing for skeletons. */
export function StandingTrial({ clip, reload }: { clip: Clip; reload: () => void }) {
  const [choosing, setChoosing] = useState(false);
  const [chosen, setChosen] = useState<Chosen | null>(null);
  const taken = clip.detail.properties.filter((one) => PROPERTY.test(one.name)).map((one) => one.value);
  const choose = async (id: string) => {
    setChoosing(false);
    try {
      const { name } = await get("/documents/{id}", { path: { id } });
      setChosen({ id, name, trials: [clip.id] });
    } catch (error) {
      refuse(error);
    }
  };
  if (!clip.skeleton.view.markers) return null;
  return (
    <div class="row wrap" title={g("help.standingTrial")}>
      <span>
        <span class="dim">{g("label.standingTrial")}:</span> {taken.join(", ") || g("label.noStandingTrial")}
      </span>
      <span class="tail" />
      {clip.pinned === null && mayEdit() && (
        <>
          <button type="button" class="button dense" onClick={() => setChoosing(true)}>
            {g("button.chooseStanding")}
          </button>
          <button
            type="button"
            class="button dense"
            onClick={() => setChosen({ id: clip.id, name: clip.detail.name, trials: [] })}
          >
            {g("button.useAsStanding")}
          </button>
        </>
      )}
      {choosing && (
        <Chooser
          title={g("label.standingTrial")}
          without={clip.id}
          onClose={() => setChoosing(false)}
          onChoose={(id) => void choose(id)}
        />
      )}
      {chosen && (
        <StandingTrialDialog
          standing={chosen.id}
          name={chosen.name}
          trials={chosen.trials}
          onClose={() => setChosen(null)}
          onDone={() => {
            setChosen(null);
            reload();
          }}
        />
      )}
    </div>
  );
}
