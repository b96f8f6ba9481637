/** One clip of a model in the table: taken or not, values that can be written, phases, and why it was left out. */
import { useState } from "preact/hooks";
import { ask, get } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { Icon } from "../../ui/icons";
import { w } from "../../words";
import type { Corrections } from "./corrections";
import type { Row } from "./model";
import { flagOf, nameOf, reasonOf } from "./names";
import { b } from "./words";

export type Extra = Record<string, Record<string, string>>;

export function ExampleRow({
  row,
  names,
  units,
  valueOf,
  corrections,
  chosen,
  onChoose,
}: {
  row: Row;
  names: string[];
  units: Map<string, string>;
  valueOf: (row: Row, name: string) => unknown;
  corrections: Corrections;
  chosen: boolean;
  onChoose: () => void;
}) {
  const { draft } = corrections;
  const left = draft.value.left.includes(row.document);
  const times = corrections.timesOf(row);
  const set = corrections.isSet(row.document);
  const time = (frames: number | undefined) => (frames === undefined ? "–" : (frames / row.fps).toFixed(2));
  return (
    <tr
      class={`${chosen ? "chosen" : ""} ${left ? "left-out" : ""}`}
      aria-current={chosen ? "true" : undefined}
      onClick={onChoose}
    >
      <td>
        <input
          type="checkbox"
          aria-label={b("label.includeClip", { name: row.name })}
          checked={!left}
          onClick={(event) => event.stopPropagation()}
          onChange={(event) => corrections.leave([row.document], !event.currentTarget.checked)}
        />
      </td>
      <td>
        <button type="button" class="as-link name" onClick={onChoose}>
          {row.name}
        </button>
      </td>
      <td class="dim">{row.subject === row.document ? "" : row.subject}</td>
      {names.map((name) => (
        <td key={name} class="n">
          <Cell
            row={row}
            name={name}
            unit={units.get(name) ?? ""}
            value={String(valueOf(row, name))}
            edited={draft.value.edited[row.document]?.[name] !== undefined}
            corrections={corrections}
          />
        </td>
      ))}
      <td class={`n ${set ? "set" : ""}`}>{time(times?.t1)}</td>
      <td class={`n ${set ? "set" : ""}`}>{time(times?.t2)}</td>
      <td class={`n ${set ? "set" : ""}`}>{time(times?.end)}</td>
      <td>
        {left ? (
          <span class="dim">{b("label.notTaken")}</span>
        ) : set && times ? (
          <span class="support inside">
            <Icon name="check" />
            {b("label.corrected")}
          </span>
        ) : row.used ? (
          <span class="dim">{row.flags.map(flagOf).join(", ")}</span>
        ) : (
          <span class="support gap" title={row.why ?? ""}>
            <Icon name="warn" />
            {reasonOf(row.reason ?? "")}
          </span>
        )}
      </td>
    </tr>
  );
}

function Cell({
  row,
  name,
  unit,
  value,
  edited,
  corrections,
}: {
  row: Row;
  name: string;
  unit: string;
  value: string;
  edited: boolean;
  corrections: Corrections;
}) {
  const [text, setText] = useState<string | null>(null);
  const keep = () => {
    if (text === null || text.trim() === value) {
      setText(null);
      return;
    }
    const said = text.trim();
    setText(null);
    void write(row, name, unit, said, value, corrections).catch(refuse);
  };
  return (
    <input
      class={`field cell ${edited ? "edited" : ""}`}
      inputMode="decimal"
      aria-label={b("label.cellOf", { name: row.name, attribute: nameOf(name) })}
      value={text ?? value}
      onFocus={(event) => event.currentTarget.select()}
      onInput={(event) => setText(event.currentTarget.value)}
      onBlur={keep}
      onKeyDown={(event) => {
        if (event.key === "Enter") event.currentTarget.blur();
        if (event.key === "Escape") {
          setText(null);
          event.currentTarget.value = value;
          event.currentTarget.blur();
        }
      }}
    />
  );
}

/** Into the document itself, as a revision that can be taken back. */
async function write(
  row: Row,
  name: string,
  unit: string,
  value: string,
  before: string,
  corrections: Corrections,
): Promise<void> {
  const one = await get("/documents/{id}", { path: { id: row.document } });
  const old = one.properties;
  const place = old.findIndex((property) => property.name === name);
  const next =
    place < 0
      ? [...old, { name, value, unit }]
      : old.map((property, at) => (at === place ? { ...property, value } : property));
  await ask("patch", "/documents/{id}", {
    path: { id: row.document },
    body: { properties: value ? next : old.filter((property) => property.name !== name) } as never,
    match: one.revision,
  });
  corrections.edit({ [row.document]: { [name]: value } }, async () => {
    await ask("patch", "/documents/{id}", { path: { id: row.document }, body: { properties: old } as never });
    note(b("label.valueBack", { name: row.name, value: before }));
  });
  note(b("label.valueWritten", { name: row.name, attribute: nameOf(name), value }), {
    action: { text: w("button.undo"), run: () => corrections.undo() },
  });
}
