/** Values of many clips at once, as they come from a sheet: pasted, written into the documents. */
import { useState } from "preact/hooks";
import { address, ask, fetched, get, type Schemas } from "../../api/client";
import { note } from "../../state/session/notes";
import { Dialog } from "../../ui/Dialog";
import { Trouble } from "../../ui/Trouble";
import { w } from "../../words";
import type { Corrections } from "./corrections";
import type { Model } from "./model";
import { b } from "./words";

export function PasteTable({
  model,
  corrections,
  onClose,
}: {
  model: Model;
  corrections: Corrections;
  onClose: () => void;
}) {
  const [text, setText] = useState("");
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const example = ["name", ...model.attributes.map((one) => (one.unit ? `${one.name} (${one.unit})` : one.name))].join(
    "\t",
  );
  const write = async () => {
    setBusy(true);
    try {
      const answer = await fetched(address("/properties", {}, { project: model.result.project }), {
        method: "POST",
        headers: { "content-type": "text/csv" },
        body: text,
      });
      const { items } = (await answer.json()) as Schemas["ChangedDocuments"];
      const given = items.filter((one) => model.byId.has(one.id));
      corrections.edit(
        await changedValues(
          model,
          given.map((one) => one.id),
        ),
        async () => {
          for (const one of items)
            await ask("post", "/documents/{id}/undo", {
              path: { id: one.id },
              query: { revision: one.revision },
              match: one.revision,
            });
          note(b("label.pasteBack", { n: items.length }));
        },
      );
      note(b("label.pasted", { n: given.length }), {
        action: { text: w("button.undo"), run: () => corrections.undo() },
      });
      onClose();
    } catch (refused) {
      setError(refused);
      setBusy(false);
    }
  };
  return (
    <Dialog title={b("label.paste")} onClose={onClose} wide>
      <form
        class="keep-form"
        onSubmit={(event) => {
          event.preventDefault();
          void write();
        }}
      >
        <p class="dim">{b("help.pasteHelp")}</p>
        <textarea
          class="field code"
          rows={10}
          aria-label={b("label.paste")}
          placeholder={`${example}\n…`}
          value={text}
          onInput={(event) => setText(event.currentTarget.value)}
        />
        <Trouble error={error} />
        <div class="row">
          <span class="grow" />
          <button type="submit" class="button primary" disabled={busy || !text.trim()}>
            {b("button.writeValues")}
          </button>
        </div>
      </form>
    </Dialog>
  );
}

const AT_ONCE = 8;

/** Of documents, the values that are not those that the model was fitted with. */
async function changedValues(model: Model, ids: string[]): Promise<Record<string, Record<string, string>>> {
  const found: Record<string, Record<string, string>> = {};
  for (let first = 0; first < ids.length; first += AT_ONCE) {
    await Promise.all(
      ids.slice(first, first + AT_ONCE).map(async (id) => {
        const { properties } = await get("/documents/{id}", { path: { id } });
        for (const { name } of model.attributes) {
          const value = properties.find((one) => one.name === name)?.value;
          if (value !== undefined && Number(value) !== model.byId.get(id)![name])
            found[id] = { ...found[id], [name]: value };
        }
      }),
    );
  }
  return found;
}
