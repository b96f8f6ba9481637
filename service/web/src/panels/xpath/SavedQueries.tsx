/** Questions that the team saved, and saving one. */
import { useState } from "preact/hooks";
import { ask, get } from "../../api/client";
import { note, refuse } from "../../state/notes";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";

export function SavedQueries({ text, onChoose }: { text: string; onChoose: (query: string) => void }) {
  const [saving, setSaving] = useState(false);
  const [name, setName] = useState("");
  const saved = useAsync((signal) => get("/queries", { query: { limit: 100 }, signal }), []);
  const save = async () => {
    try {
      await ask("put", "/queries/{name}", { path: { name }, body: { q: text, description: "" } });
      note(w("savedAs", { name }));
      setSaving(false);
      saved.again();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <>
      <Menu label={w("savedQueries")} className="button quiet" side="right" items={[
        { text: w("saveQuery"), icon: "plus", disabled: !text.trim(), run: () => setSaving(true) },
        ...(saved.value?.items ?? []).map((one) => ({ text: one.name, detail: one.q.length > 40 ? `${one.q.slice(0, 40)}…` : one.q, run: () => onChoose(one.q) })),
      ]}><Icon name="down" /></Menu>
      {saving && (
        <Dialog title={w("saveQuery")} onClose={() => setSaving(false)}>
          <form onSubmit={(event) => { event.preventDefault(); if (name.trim()) void save(); }}>
            <p><code>{text}</code></p>
            <p class="row"><input class="field grow" autoFocus aria-label={w("name")} placeholder={w("name")} value={name} onInput={(event) => setName(event.currentTarget.value)} />
              <button type="submit" class="button primary" disabled={!name.trim()}>{w("save")}</button></p>
          </form>
        </Dialog>
      )}
    </>
  );
}
