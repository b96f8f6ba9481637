/** Questions that the team saved, and saving one. */
import { useState } from "preact/hooks";
import { ask, get } from "../../api/client";
import { note } from "../../state/session/notes";
import { AskName } from "../../ui/forms/AskName";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";

export function SavedQueries({ text, onChoose }: { text: string; onChoose: (query: string) => void }) {
  const [saving, setSaving] = useState(false);
  const saved = useAsync((signal) => get("/queries", { query: { limit: 100 }, signal }), []);
  const save = async (name: string) => {
    await ask("put", "/queries/{name}", { path: { name }, body: { q: text, description: "" } });
    note(w("label.savedAs", { name }));
    saved.again();
  };
  return (
    <>
      <Menu
        label={w("label.savedQueries")}
        className="button quiet"
        side="right"
        items={[
          { text: w("button.saveQuery"), icon: "plus", disabled: !text.trim(), run: () => setSaving(true) },
          ...(saved.value?.items ?? []).map((one) => ({
            text: one.name,
            detail: one.q.length > 40 ? `${one.q.slice(0, 40)}…` : one.q,
            run: () => onChoose(one.q),
          })),
        ]}
      >
        {w("label.savedQueries")}
        <Icon name="down" />
      </Menu>
      {saving && (
        <AskName title={w("button.saveQuery")} onName={save} onClose={() => setSaving(false)}>
          <p>
            <code>{text}</code>
          </p>
        </AskName>
      )}
    </>
  );
}
