/** What can be done with the hits of a search: label their frames, collect, compose or export their clips. */
import { useEffect, useState } from "preact/hooks";
import { address, ask, fetched, type Schemas } from "../../../api/client";
import { loadVocabulary, namesLike } from "../../../state/library/vocabulary";
import { askMe, mayEdit } from "../../../state/session/me";
import { note, refuse } from "../../../state/session/notes";
import { go } from "../../../state/session/route";
import { CollectClips } from "../../../ui/clips/CollectClips";
import { ExportClipsDialog } from "../../../ui/exporting/ExportClipsDialog";
import { exportClipsItems } from "../../../ui/exporting/exportClips";
import { AskName } from "../../../ui/forms/AskName";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { w } from "../../../words";
import { composerOf, documentsOf, labelTable, type Hit } from "./asked";

type Changed = Schemas["ChangedDocuments"]["items"];
const MOST_NAMES = 12;

/** poses: hits of one frame, of which no motion can be composed. onChanged: tell that these clips were edited. */
export function HitActions({
  hits,
  poses,
  onChanged,
}: {
  hits: Hit[];
  poses: boolean;
  onChanged: (documents: string[]) => void;
}) {
  const [asks, setAsks] = useState<"label" | "collect" | "export" | null>(null);
  useEffect(() => void askMe(), []);
  const none = !hits.length;
  return (
    <div class="row wrap hit-actions" role="toolbar" aria-label={w("label.hitActions")}>
      {mayEdit() && (
        <button type="button" class="button dense" disabled={none} onClick={() => setAsks("label")}>
          <Icon name="label" />
          {w("button.labelHits", { n: hits.length })}
        </button>
      )}
      {mayEdit() && (
        <button type="button" class="button dense" disabled={none} onClick={() => setAsks("collect")}>
          <Icon name="list" />
          {w("button.collect")}
        </button>
      )}
      {!poses && (
        <button type="button" class="button dense" disabled={none} onClick={() => go(composerOf(hits))}>
          <Icon name="compose" />
          {w("button.composeThese")}
        </button>
      )}
      {!none && (
        <Menu
          label={w("button.exportWord")}
          className="button dense"
          items={() => exportClipsItems(documentsOf(hits), () => setAsks("export"))}
        >
          <Icon name="export" />
          {w("button.exportWord")}
          <Icon name="down" />
        </Menu>
      )}
      {asks === "collect" && <CollectClips ids={documentsOf(hits)} onClose={() => setAsks(null)} />}
      {asks === "export" && <ExportClipsDialog ids={documentsOf(hits)} onClose={() => setAsks(null)} />}
      {asks === "label" && <LabelHits hits={hits} onChanged={onChanged} onClose={() => setAsks(null)} />}
    </div>
  );
}

/** Label the frames of all hits with one request, which the toast takes back. */
function LabelHits({
  hits,
  onChanged,
  onClose,
}: {
  hits: Hit[];
  onChanged: (documents: string[]) => void;
  onClose: () => void;
}) {
  useEffect(() => void loadVocabulary(), []);
  const label = async (name: string) => {
    const answer = await fetched(address("/labels"), {
      method: "PUT",
      headers: { "content-type": "text/csv" },
      body: labelTable(hits, name),
    });
    const { items } = (await answer.json()) as { items: Changed };
    const text = w("label.hitsLabelled", { n: hits.length, name });
    note(text, items.length ? { action: { text: w("button.undo"), run: () => void undo(items, onChanged) } } : {});
    onChanged(items.map((one) => one.id));
  };
  return (
    <AskName
      title={w("label.labelHits", { n: hits.length })}
      label={w("label.spanName")}
      verb={w("button.nameThese")}
      names={(text) => namesLike(text, MOST_NAMES)}
      onName={label}
      onClose={onClose}
    >
      <p class="dim">{w("help.labelHitsHelp", { n: documentsOf(hits).length })}</p>
    </AskName>
  );
}

/** Undo the revisions that labelling made; a clip that was edited since keeps its labels, and the refusal says so. */
async function undo(items: Changed, onChanged: (documents: string[]) => void): Promise<void> {
  const undone: string[] = [];
  for (const { id, revision } of items) {
    try {
      await ask("post", "/documents/{id}/undo", { path: { id }, query: { revision }, match: revision });
      undone.push(id);
    } catch (error) {
      refuse(error);
    }
  }
  onChanged(undone);
}
