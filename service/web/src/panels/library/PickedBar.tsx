/** What can be done with the clips that are picked. */
import { useEffect, useState } from "preact/hooks";
import { ask } from "../../api/client";
import * as library from "../../state/library/library";
import { askMe, mayEdit } from "../../state/session/me";
import { note, refuse } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { namesLike } from "../../state/library/vocabulary";
import { CollectClips } from "../../ui/clips/CollectClips";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { ArraysDialog } from "../../ui/exporting/ArraysDialog";
import { ExportClipsDialog } from "../../ui/exporting/ExportClipsDialog";
import { exportClipsItems } from "../../ui/exporting/exportClips";
import { ShareDialog } from "../../ui/exporting/ShareDialog";
import { w } from "../../words";
import { ToProject } from "./ToProject";

export function PickedBar() {
  const [naming, setNaming] = useState(false);
  const [collecting, setCollecting] = useState(false);
  const [sharing, setSharing] = useState(false);
  const [exporting, setExporting] = useState(false);
  const [numbers, setNumbers] = useState(false);
  const [going, setGoing] = useState<"" | "copy" | "move">("");
  useEffect(() => void askMe(), []);
  const ids = [...library.picked.value];
  if (!ids.length) return null;
  const total = library.total.value ?? 0;
  const edits = mayEdit();
  return (
    <div class="picked-bar" role="toolbar" aria-label={w("label.picked", { n: ids.length })}>
      <strong>{w("label.picked", { n: ids.length })}</strong>
      {edits && (
        <button type="button" class="button dense" onClick={() => setNaming(true)}>
          <Icon name="label" />
          {w("button.nameThese")}
        </button>
      )}
      <button type="button" class="button dense" onClick={() => go(`/compose?s=${ids.join(",")}`)}>
        <Icon name="compose" />
        {w("button.composeThese")}
      </button>
      <button type="button" class="button dense" onClick={() => go(`/measure?doc=${ids.join("&doc=")}`)}>
        <Icon name="chart" />
        {w("button.measureThese")}
      </button>
      <Menu
        label={w("button.exportWord")}
        className="button dense"
        items={() => [
          ...exportClipsItems(ids, () => setExporting(true)),
          { text: w("label.arraysFile"), run: () => setNumbers(true) },
        ]}
      >
        <Icon name="export" />
        {w("button.exportWord")}
        <Icon name="down" />
      </Menu>
      {edits && (
        <button type="button" class="button dense" onClick={() => setCollecting(true)}>
          <Icon name="list" />
          {w("button.collect")}
        </button>
      )}
      {edits && (
        <button type="button" class="button dense" onClick={() => setSharing(true)}>
          <Icon name="eye" />
          {w("button.shareLink")}
        </button>
      )}
      {edits && (
        <Menu
          label={w("label.project")}
          className="button dense"
          items={[
            { text: w("button.copyToProject"), run: () => setGoing("copy") },
            { text: w("button.moveToProject"), run: () => setGoing("move") },
          ]}
        >
          <Icon name="layer" />
          {w("label.project")}
          <Icon name="down" />
        </Menu>
      )}
      {edits && (
        <button type="button" class="button dense" onClick={() => void library.removeDocuments(ids)}>
          <Icon name="trash" />
          {w("button.delete")}
        </button>
      )}
      <span class="grow" />
      {total > ids.length && (
        <button type="button" class="button quiet dense" onClick={() => void library.pickRows(0, total - 1)}>
          {w("button.pickAll", { n: total })}
        </button>
      )}
      <button type="button" class="button quiet dense" onClick={() => (library.picked.value = new Set())}>
        {w("button.pickNone")}
      </button>
      {going && <ToProject ids={ids} move={going === "move"} onClose={() => setGoing("")} />}
      {exporting && <ExportClipsDialog ids={ids} onClose={() => setExporting(false)} />}
      {numbers && (
        <ArraysDialog
          source={{ selection: { documents: ids } }}
          about={w("help.arraysOfClips", { n: ids.length })}
          onClose={() => setNumbers(false)}
        />
      )}
      {sharing && <ShareDialog ids={ids} onClose={() => setSharing(false)} />}
      {collecting && <CollectClips ids={ids} onClose={() => setCollecting(false)} />}
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
      note(w("label.labelled", { n: ids.length, name: chosen }));
      library.refresh();
      onClose();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <Dialog title={w("label.labelPicked")} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (name.trim()) void done(name.trim());
        }}
      >
        <p class="dim">{w("help.labelPickedHelp")}</p>
        <p class="row">
          <input
            class="field grow"
            autoFocus
            list="picked-names"
            aria-label={w("label.spanName")}
            placeholder={w("label.spanName")}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button type="submit" class="button primary" disabled={!name.trim()}>
            {w("button.nameThese")}
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
