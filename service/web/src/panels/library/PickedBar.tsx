/** What can be done with the clips that are picked. */
import { useEffect, useState } from "preact/hooks";
import { ask, fetched, address } from "../../api/client";
import { saveBlob } from "../../ui/exporting/saveBlob";
import * as library from "../../state/library/library";
import { writtenFormats } from "../../state/session/formats";
import { askMe, mayEdit } from "../../state/session/me";
import { note, refuse } from "../../state/session/notes";
import { collectionsChanged } from "../../state/library/collections";
import { go } from "../../state/session/route";
import { namesLike } from "../../state/library/vocabulary";
import { AskName } from "../../ui/forms/AskName";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { ShareDialog } from "../../ui/exporting/ShareDialog";
import { w } from "../../words";
import { ToProject } from "./ToProject";

export function PickedBar() {
  const [naming, setNaming] = useState(false);
  const [collecting, setCollecting] = useState(false);
  const [sharing, setSharing] = useState(false);
  const [going, setGoing] = useState<"" | "copy" | "move">("");
  useEffect(() => void askMe(), []);
  const ids = [...library.picked.value];
  if (!ids.length) return null;
  const edits = mayEdit();
  const exportAll = async (format: string) => {
    try {
      const answer = await fetched(address("/exports"), {
        method: "POST",
        headers: { "content-type": "application/json" },
        body: JSON.stringify({ selection: { documents: ids }, format }),
      });
      saveBlob(await answer.blob(), `clips ${format}.zip`);
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="picked-bar" role="toolbar" aria-label={w("picked", { n: ids.length })}>
      <strong>{w("picked", { n: ids.length })}</strong>
      {edits && (
        <button type="button" class="button dense" onClick={() => setNaming(true)}>
          <Icon name="label" />
          {w("nameThese")}
        </button>
      )}
      <button type="button" class="button dense" onClick={() => go(`/compose?s=${ids.join(",")}`)}>
        <Icon name="compose" />
        {w("composeThese")}
      </button>
      <Menu
        label={w("exportWord")}
        className="button dense"
        items={() =>
          writtenFormats().map(({ name, label }) => ({
            text: w("exportAs", { format: label }),
            run: () => void exportAll(name),
          }))
        }
      >
        <Icon name="export" />
        {w("exportWord")}
        <Icon name="down" />
      </Menu>
      {edits && (
        <button type="button" class="button dense" onClick={() => setCollecting(true)}>
          <Icon name="list" />
          {w("collect")}
        </button>
      )}
      {edits && (
        <button type="button" class="button dense" onClick={() => setSharing(true)}>
          <Icon name="eye" />
          {w("shareLink")}
        </button>
      )}
      {edits && (
        <Menu
          label={w("project")}
          className="button dense"
          items={[
            { text: w("copyToProject"), run: () => setGoing("copy") },
            { text: w("moveToProject"), run: () => setGoing("move") },
          ]}
        >
          <Icon name="layer" />
          {w("project")}
          <Icon name="down" />
        </Menu>
      )}
      {edits && (
        <button type="button" class="button dense" onClick={() => void library.removeDocuments(ids)}>
          <Icon name="trash" />
          {w("delete")}
        </button>
      )}
      <span class="grow" />
      <button type="button" class="button quiet dense" onClick={() => (library.picked.value = new Set())}>
        {w("pickNone")}
      </button>
      {going && <ToProject ids={ids} move={going === "move"} onClose={() => setGoing("")} />}
      {sharing && <ShareDialog ids={ids} onClose={() => setSharing(false)} />}
      {collecting && <Collect ids={ids} onClose={() => setCollecting(false)} />}
      {naming && <NameAll ids={ids} onClose={() => setNaming(false)} />}
    </div>
  );
}

function NameAll({ ids, onClose }: { ids: string[]; onClose: () => void }) {
  const [name, setName] = useState("");
  const done = async (chosen: string) => {
    try {
      await ask("post", "/labels", {
        body: { name: chosen, xpath: "//frame", document: ids, remove: false, strict: false },
      });
      note(w("labelled", { n: ids.length, name: chosen }));
      library.refresh();
      onClose();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <Dialog title={w("labelPicked")} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (name.trim()) void done(name.trim());
        }}
      >
        <p class="dim">{w("labelPickedHelp")}</p>
        <p class="row">
          <input
            class="field grow"
            autoFocus
            list="picked-names"
            aria-label={w("spanName")}
            placeholder={w("spanName")}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button type="submit" class="button primary" disabled={!name.trim()}>
            {w("nameThese")}
          </button>
        </p>
        <datalist id="picked-names">
          {namesLike(name, 12).map((one) => (
            <option key={one} value={one} />
          ))}
        </datalist>
      </form>
    </Dialog>
  );
}

/** Keep the picked clips under a name that every list and command takes. */
function Collect({ ids, onClose }: { ids: string[]; onClose: () => void }) {
  const keep = async (name: string) => {
    await ask("put", "/collections/{name}", { path: { name }, body: { documents: ids, description: "" } });
    note(w("savedAs", { name }));
    collectionsChanged.value++;
  };
  return (
    <AskName title={w("collect")} onName={keep} onClose={onClose}>
      <p class="dim">{w("collectHelp")}</p>
    </AskName>
  );
}
