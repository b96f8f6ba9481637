/** The clips of a model: their values, their phases to correct, those that were left out and why; fitted again from here. */
import { useMemo, useState } from "preact/hooks";
import { get } from "../../api/client";
import { param, setParams } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import type { Corrections } from "./corrections";
import { FitProgress, FitTrouble, useFit } from "./fitting";
import type { Model, Row } from "./model";
import { PasteTable } from "./PasteTable";
import { PhaseEditor } from "./PhaseEditor";
import { ExampleRow, type Extra } from "./ExampleRow";
import type { Speeds } from "./speeds";
import { nameOf, reasonOf, unitOf } from "./names";
import { b } from "./words";

const MOST_ROWS = 200;
const MOST_ASKED = 60; // clips left out whose values are fetched one by one

export function Examples({
  model,
  corrections,
  speeds,
}: {
  model: Model;
  corrections: Corrections;
  speeds: Speeds | undefined;
}) {
  const [text, setText] = useState("");
  const [sort, setSort] = useState<{ by: string; down: boolean }>({ by: "", down: false });
  const [pasting, setPasting] = useState(false);
  const fit = useFit();
  const names = model.attributes.map((one) => one.name);
  const units = new Map(model.attributes.map((one) => [one.name, one.unit]));
  // What a model left out has no values in it.
  const extra = useAsync<Extra>(
    async (signal) => {
      const found: Extra = {};
      await Promise.all(
        model.rows
          .filter((one) => !one.used)
          .slice(0, MOST_ASKED)
          .map(async ({ document }) => {
            const one = await get("/documents/{id}", { path: { id: document }, signal });
            found[document] = Object.fromEntries(one.properties.map((property) => [property.name, property.value]));
          }),
      );
      return found;
    },
    [model],
  );
  const draft = corrections.draft.value;
  const valueOf = (row: Row, name: string): unknown =>
    draft.edited[row.document]?.[name] ?? row[name] ?? extra.value?.[row.document]?.[name] ?? "";
  const rows = useMemo(() => {
    const wanted = text.trim().toLowerCase();
    const found = model.rows.filter(
      (one) =>
        !wanted ||
        `${one.name} ${one.subject ?? ""} ${one.reason ? reasonOf(one.reason) : ""}`.toLowerCase().includes(wanted),
    );
    // At first those that were left out stand above: they want somebody's eye.
    if (!sort.by)
      return found.toSorted(
        (one, other) =>
          Number(one.used) - Number(other.used) || one.name.localeCompare(other.name, undefined, { numeric: true }),
      );
    const key = (row: Row) =>
      (names.includes(sort.by) ? Number(valueOf(row, sort.by)) : row[sort.by]) as number | string | null;
    const order = found.toSorted((one, other) => {
      const [x, y] = [key(one) ?? "", key(other) ?? ""];
      return typeof x === "number" && typeof y === "number"
        ? x - y
        : String(x).localeCompare(String(y), undefined, { numeric: true });
    });
    return sort.down ? order.reverse() : order;
  }, [model, text, sort, sort.by && names.includes(sort.by) ? draft : null, extra.value]);
  const chosen = model.byId.get(param("clip")) ?? rows[0];
  const count = corrections.count.value;
  const again = () =>
    void fit.start(
      { ...corrections.request, name: model.result.name, project: model.result.project ?? undefined },
      true,
    );
  const head = (by: string, words: string, unit = "") => (
    <th
      key={by}
      scope="col"
      class={names.includes(by) || by.endsWith("_seconds") ? "n" : ""}
      aria-sort={sort.by === by ? (sort.down ? "descending" : "ascending") : "none"}
    >
      <button type="button" class="sort" onClick={() => setSort({ by, down: sort.by === by && !sort.down })}>
        {words}
        {unit && <span class="dim"> {unit}</span>}
        {sort.by === by && <Icon name="down" />}
      </button>
    </th>
  );
  return (
    <div class="reach-examples">
      <div class="row wrap examples-tools">
        <input
          class="field"
          type="search"
          aria-label={w("label.search")}
          placeholder={b("label.filterClips")}
          value={text}
          onInput={(event) => setText(event.currentTarget.value)}
        />
        <span class="dim">{b("label.usedOf", { used: model.used.length, n: model.rows.length })}</span>
        <span class="grow" />
        <button type="button" class="button quiet" onClick={() => setPasting(true)}>
          {b("label.paste")}
        </button>
        <button
          type="button"
          class="button quiet icon"
          aria-label={w("button.undo")}
          title={w("button.undo")}
          disabled={!corrections.steps.value.length}
          onClick={() => corrections.undo()}
        >
          <Icon name="undo" />
        </button>
        <button type="button" class={`button ${count ? "primary" : ""}`} disabled={fit.busy} onClick={again}>
          {count ? b("button.fitAgainWith", { n: count }) : b("button.fitAgain")}
        </button>
      </div>
      {fit.job && <FitProgress job={fit.job} />}
      <FitTrouble
        error={fit.error}
        onExclude={(documents) => {
          corrections.leave(documents, true);
          again();
        }}
      />
      <Trouble error={extra.error} retry={extra.again} />
      <div class="examples-table" tabIndex={0} role="region" aria-label={b("label.examples")}>
        <table>
          <thead>
            <tr>
              <th>
                <span class="unseen">{b("label.include")}</span>
              </th>
              {head("name", w("label.name"))}
              {head("subject", b("label.subject"))}
              {names.map((one) => head(one, nameOf(one), unitOf(units.get(one) ?? "")))}
              {head("t1_seconds", "t1", "s")}
              {head("t2_seconds", "t2", "s")}
              {head("end_seconds", b("label.endShort"), "s")}
              {head("reason", b("label.state"))}
            </tr>
          </thead>
          <tbody>
            {rows.slice(0, MOST_ROWS).map((row) => (
              <ExampleRow
                key={row.document}
                row={row}
                names={names}
                units={units}
                valueOf={valueOf}
                corrections={corrections}
                chosen={row === chosen}
                onChoose={() => setParams({ clip: row.document })}
              />
            ))}
          </tbody>
        </table>
        {rows.length > MOST_ROWS && <p class="dim more-rows">{b("label.moreRows", { n: rows.length - MOST_ROWS })}</p>}
        {!rows.length && <p class="dim more-rows">{w("help.nothingFound")}</p>}
      </div>
      {chosen && (
        <PhaseEditor
          key={chosen.document}
          model={model}
          row={chosen}
          corrections={corrections}
          values={speeds?.of(chosen.document) ?? null}
        />
      )}
      {pasting && <PasteTable model={model} corrections={corrections} onClose={() => setPasting(false)} />}
    </div>
  );
}
