/** Frames of many clips, or of a query, as one file of numbers; and the lines that give the same array in scripts. */
import { useState } from "preact/hooks";
import { address, fetched } from "../../api/client";
import { needsToken } from "../../state/session/me";
import { note, refuse } from "../../state/session/notes";
import { w } from "../../words";
import { Dialog } from "../Dialog";
import {
  arraysByCommand,
  arraysByCurl,
  arraysByPython,
  fileName,
  type ArraysRequest,
  type ArraysSource,
} from "./arrays";
import { saveBlob } from "./saveBlob";
import { ScriptLines } from "./ScriptLines";
import "../../styles/shared.css";

const SPACES = [
  { space: "positions", label: "label.arraysPositions", help: "help.arraysPositions" },
  { space: "rotations", label: "label.arraysRotations", help: "help.arraysRotations" },
  { space: "channels", label: "label.arraysChannels", help: "help.arraysChannels" },
] as const;
const FORMS = { npz: "NumPy", parquet: "Parquet", csv: "CSV" } as const;

/** about: a sentence on the clips or the query. */
export function ArraysDialog({ source, about, onClose }: { source: ArraysSource; about: string; onClose: () => void }) {
  const [space, setSpace] = useState<ArraysRequest["space"]>("positions");
  const [form, setForm] = useState<keyof typeof FORMS>("npz");
  const [shared, setShared] = useState(false);
  const [busy, setBusy] = useState(false);
  const request: ArraysRequest = { ...source, space, columns: shared ? "shared" : "all", as: form };
  const lines = {
    Python: arraysByPython(request, location.origin, needsToken()),
    Command: arraysByCommand(request, location.origin),
    Curl: arraysByCurl(request, location.origin, needsToken()),
  };
  const download = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      const answer = await fetched(address("/arrays"), {
        method: "POST",
        headers: { "content-type": "application/json" },
        body: JSON.stringify(request),
      });
      saveBlob(await answer.blob(), fileName(request));
      const notices = answer.headers.get("x-mcml-notices");
      if (notices) note(notices);
      onClose();
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={w("button.exportArrays")} onClose={onClose} wide>
      <form class="arrays-form" onSubmit={(event) => void download(event)}>
        <p class="dim">{about}</p>
        <fieldset>
          <legend>{w("label.numbersOf")}</legend>
          {SPACES.map((one) => (
            <label key={one.space} class="row">
              <input type="radio" name="space" checked={space === one.space} onChange={() => setSpace(one.space)} />
              {w(one.label)} <span class="dim">{w(one.help)}</span>
            </label>
          ))}
        </fieldset>
        <label class="row">
          <input type="checkbox" checked={shared} onChange={(event) => setShared(event.currentTarget.checked)} />
          {w("label.columnsShared")} <span class="dim">{w("help.columnsShared")}</span>
        </label>
        <label class="row">
          {w("label.format")}
          <select
            class="field"
            value={form}
            onChange={(event) => setForm(event.currentTarget.value as keyof typeof FORMS)}
          >
            {Object.entries(FORMS).map(([name, text]) => (
              <option key={name} value={name}>
                {text}
              </option>
            ))}
          </select>
        </label>
        <ScriptLines lines={lines} />
        <p class="row">
          <button type="submit" class="button primary" disabled={busy}>
            {busy ? w("label.loading") : w("button.downloadArrays", { name: fileName(request) })}
          </button>
        </p>
      </form>
    </Dialog>
  );
}
