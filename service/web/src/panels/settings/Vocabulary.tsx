/** The motion names that a project agrees on: what they mean there, and their colours. */
import { useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { nameColour } from "../../motion/timeline/colours";
import { refuse } from "../../state/session/notes";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { useTurns } from "../../ui/useTurns";
import { number, w } from "../../words";
import { Table } from "./tables";
import { s } from "./words";

type Agreed = Schemas["VocabularyWord"];
type Kept = Schemas["Vocabulary"];
const COLOURS = [0, 1, 2, 3, 4, 5, 6, 7];

export function Vocabulary({ project, edits }: { project: string; edits: boolean }) {
  const found = useAsync((signal) => get("/vocabulary", { query: { project }, signal }), [project]);
  const inTurn = useTurns<Kept>();
  const [name, setName] = useState("");
  const [description, setDescription] = useState("");
  const items = found.value?.items ?? [];
  /** An edit is made to what the one before left. */
  const save = async (edit: (items: Agreed[]) => Agreed[]) => {
    const read = found.value;
    if (!read) return false;
    try {
      await inTurn(async (before = read) => {
        const next = edit(before.items);
        const match = before.version ? { match: before.version } : {};
        let kept = { ...before, items: next, version: 0 };
        if (next.length)
          kept = await ask("put", "/vocabulary", { query: { project }, body: { items: next }, ...match });
        else if (before.version) await ask("delete", "/vocabulary", { query: { project }, ...match });
        found.set(kept);
        return kept;
      });
      return true;
    } catch (error) {
      refuse(error);
      found.again();
      return false;
    }
  };
  const add = async () => {
    if (!(await save((held) => [...held, { name: name.trim(), description: description.trim() }]))) return;
    setName("");
    setDescription("");
  };
  const change = (name: string, change: Partial<Agreed>) =>
    void save((held) => held.map((one) => (one.name === name ? { ...one, ...change } : one)));
  const swatch = (one: Agreed) => (
    <span
      class="swatch"
      style={{
        background: one.colour === null || one.colour === undefined ? nameColour(one.name) : `var(--name${one.colour})`,
      }}
    />
  );
  return (
    <section>
      <h3>{s("label.vocabulary")}</h3>
      <p class="dim">{s("help.vocabularyHelp")}</p>
      <Trouble error={found.error} retry={found.again} />
      <Table
        head={[w("label.name"), s("label.meaning"), s("label.colour"), ""]}
        rows={items.map((one) => [
          <span key="n" class="row">
            {swatch(one)}
            {one.name}
          </span>,
          edits ? (
            <input
              key={`d ${one.name}`}
              class="field grow"
              aria-label={s("label.meaningOf", { name: one.name })}
              defaultValue={one.description}
              onChange={(event) => change(one.name, { description: event.currentTarget.value.trim() })}
            />
          ) : (
            one.description
          ),
          edits && (
            <select
              key="c"
              class="field"
              aria-label={s("label.colourOf", { name: one.name })}
              value={one.colour ?? ""}
              onChange={(event) =>
                change(one.name, {
                  colour: event.currentTarget.value === "" ? null : Number(event.currentTarget.value),
                })
              }
            >
              <option value="">{s("label.anyColour")}</option>
              {COLOURS.map((colour) => (
                <option key={colour} value={colour}>
                  {number(colour + 1)}
                </option>
              ))}
            </select>
          ),
          edits && (
            <button
              key="r"
              type="button"
              class="button dense"
              aria-label={s("button.removeName", { name: one.name })}
              onClick={() => void save((held) => held.filter((other) => other.name !== one.name))}
            >
              <Icon name="close" />
            </button>
          ),
        ])}
      />
      {edits && found.value && (
        <form
          class="row wrap vocabulary-add"
          aria-label={s("label.vocabulary")}
          onSubmit={(event) => {
            event.preventDefault();
            if (name.trim()) void add();
          }}
        >
          <input
            class="field"
            aria-label={s("label.newName")}
            placeholder={s("label.newName")}
            maxLength={1024}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <input
            class="field grow"
            aria-label={s("label.meaning")}
            placeholder={s("label.meaning")}
            maxLength={4096}
            value={description}
            onInput={(event) => setDescription(event.currentTarget.value)}
          />
          <button class="button" disabled={!name.trim()}>
            {w("button.add")}
          </button>
        </form>
      )}
    </section>
  );
}
