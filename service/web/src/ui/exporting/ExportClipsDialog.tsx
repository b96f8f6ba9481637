/** Several clips exported for a program or in a format, in one archive, with the same options. */
import { useEffect, useState } from "preact/hooks";
import { loadCharacters } from "../../state/clip/characters";
import { needsToken } from "../../state/session/me";
import { number, w } from "../../words";
import { Dialog } from "../Dialog";
import { exportClips } from "./exportClips";
import { ExportFields, START, TargetChoice, targetOf, targetsOf, type Given, type Known } from "./ExportFields";
import { exportClipsByCommand, exportClipsByCurl, type ExportOptions } from "./exportOptions";
import { ScriptLines } from "./ScriptLines";
import "../../styles/shared.css";

const MOST_IN_LINES = 100;
/** Clips differ: those that state no unit or axis are listed in the archive. */
const ANY: Known = { unit: true, up: true, rate: null };

export function ExportClipsDialog({ ids, onClose }: { ids: string[]; onClose: () => void }) {
  const targets = targetsOf();
  const [key, setKey] = useState<string | null>(null);
  const [given, setGiven] = useState<Given>(START);
  const [busy, setBusy] = useState(false);
  useEffect(() => void loadCharacters(), []);
  const chosen = targets.find((one) => one.key === key) ?? targets[0];
  if (!chosen) return null;
  const options: ExportOptions = {
    ...given,
    character: chosen.skins ? given.character : "",
    target: targetOf(chosen.key),
  };
  const download = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    const done = await exportClips(ids, options);
    setBusy(false);
    if (done) onClose();
  };
  const lines = {
    Command: exportClipsByCommand(ids, options, location.origin),
    Curl: exportClipsByCurl(ids, options, location.origin, needsToken()),
  };
  return (
    <Dialog title={w("button.exportOptions")} onClose={onClose}>
      <form class="export-form many" onSubmit={(event) => void download(event)}>
        <p class="dim">{w("help.exportClips", { n: number(ids.length) })}</p>
        <div class="export-fields">
          <TargetChoice targets={targets} chosen={chosen} onChoose={setKey} />
          <ExportFields
            known={ANY}
            loop={null}
            given={given}
            target={chosen}
            onChange={(more) => setGiven({ ...given, ...more })}
          />
        </div>
        {ids.length <= MOST_IN_LINES && <ScriptLines lines={lines} />}
        <div class="row export-done">
          <span class="grow" />
          <button type="submit" class="button primary" disabled={busy}>
            {busy ? w("label.loading") : w("button.exportWord")}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
