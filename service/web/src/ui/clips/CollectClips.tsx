/** Keep clips under a name that every list and command takes. */
import { ask } from "../../api/client";
import { collectionsChanged } from "../../state/library/collections";
import { note } from "../../state/session/notes";
import { w } from "../../words";
import { AskName } from "../forms/AskName";

export function CollectClips({ ids, onClose }: { ids: string[]; onClose: () => void }) {
  const keep = async (name: string) => {
    await ask("put", "/collections/{name}", { path: { name }, body: { documents: ids, description: "" } });
    note(w("label.savedAs", { name }));
    collectionsChanged.value++;
  };
  return (
    <AskName title={w("button.collect")} onName={keep} onClose={onClose}>
      <p class="dim">{w("help.collectHelp")}</p>
    </AskName>
  );
}
