/** What was made is kept: as a clip, as a file, as a picture. */
import { useState } from "preact/hooks";
import { address, fetched, get } from "../../api/client";
import { applyResult } from "../../api/results";
import { extensionOf, isOneFile, writtenFormats } from "../../state/session/formats";
import { note, refuse } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { saveBlob } from "../../ui/exporting/saveBlob";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import type { Blending } from "./blending";
import type { Model } from "./model";
import { b } from "./words";

const NUMBERS = { name: "npy", label: "NumPy", extension: ".npy" };

/** What one motion of a body can be saved as. */
const kinds = () => [
  ...writtenFormats("bodies")
    .filter(isOneFile)
    .map((one) => ({ name: one.name, label: one.label, extension: extensionOf(one) })),
  NUMBERS,
];

export function Keep({
  model,
  blending,
  picture,
}: {
  model: Model;
  blending: Blending;
  picture: () => Promise<Blob> | undefined;
}) {
  const [asking, setAsking] = useState(false);
  const wish = () => blending.wish();
  const suggested = () =>
    `reach, ${model.attributes.map((one) => `${one.name} ${blending.values.peek()[one.name]}`).join(", ")}`;
  const file = async (format: string, extension: string) => {
    try {
      const answer = await fetched(address("/results/{id}/synthesize", { id: model.id }, { format }), {
        method: "POST",
        headers: { "content-type": "application/json" },
        body: JSON.stringify({ parameters: wish() }),
      });
      saveBlob(await answer.blob(), `${suggested()}${extension}`);
    } catch (error) {
      refuse(error);
    }
  };
  const save = async () => {
    const blob = await picture();
    if (blob) saveBlob(blob, `${suggested()}.png`);
  };
  return (
    <div class="row wrap keep">
      <button type="button" class="button primary" onClick={() => setAsking(true)}>
        {b("button.saveAsClip")}
      </button>
      <Menu
        label={b("label.exportMade")}
        className="button"
        side="right"
        items={() => [
          ...kinds().map(({ name, label, extension }) => ({
            text: label,
            detail: extension,
            run: () => void file(name, extension),
          })),
          { text: b("label.pictureOfIt"), detail: ".png", run: () => void save() },
        ]}
      >
        {w("button.exportWord")}
        <Icon name="down" />
      </Menu>
      {asking && <Saving model={model} suggested={suggested()} wish={wish()} onClose={() => setAsking(false)} />}
    </div>
  );
}

function Saving({
  model,
  suggested,
  wish,
  onClose,
}: {
  model: Model;
  suggested: string;
  wish: object;
  onClose: () => void;
}) {
  const [name, setName] = useState(suggested);
  const [project, setProject] = useState(model.result.project ?? "");
  const [busy, setBusy] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const save = async () => {
    setBusy(true);
    try {
      const done = await applyResult(model.id, "synthesize", wish, { save: true, name, project: project || undefined });
      note(b("label.saved", { name }), {
        action: { text: w("button.open"), run: () => go(`/clips/${done.document}`) },
      });
      onClose();
    } catch (refused) {
      setError(refused);
      setBusy(false);
    }
  };
  return (
    <Dialog title={b("button.saveAsClip")} onClose={onClose}>
      <form
        class="keep-form"
        onSubmit={(event) => {
          event.preventDefault();
          void save();
        }}
      >
        <label>
          {w("label.name")}
          <input
            class="field"
            autoFocus
            required
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
        </label>
        <label>
          {w("label.project")}
          <input
            class="field"
            list="keep-projects"
            value={project}
            onInput={(event) => setProject(event.currentTarget.value)}
          />
        </label>
        <datalist id="keep-projects">
          {(projects.value?.items ?? []).map((one) => (
            <option key={one} value={one} />
          ))}
        </datalist>
        <p class="dim">{b("help.savedHelp")}</p>
        <Trouble error={error} />
        <div class="row">
          <span class="grow" />
          <button type="submit" class="button primary" disabled={busy || !name}>
            {w("button.save")}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
