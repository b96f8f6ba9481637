/** The table of frame ranges: outliers first; a row plays its range. */
import { Icon } from "../../ui/icons";
import { number } from "../../words";
import { figure, quantityName, unitName } from "./names";
import { keyOf, type Measures, type Row } from "./request";
import { m } from "./words";

const SHOWN = 200;
const FIGURES = ["minimum", "maximum", "mean", "sd", "range"] as const;

export function Rows({ found, picked, onPick }: { found: Measures; picked: string; onPick: (row: Row) => void }) {
  const rows = found.ranges.slice(0, SHOWN);
  return (
    <section class="measure-table" aria-label={m("label.tableOf")}>
      <h2 class="row wrap">
        {m("label.table")}
        <span class="dim" role="status">
          {m("label.totals", { n: found.total_ranges, clips: number(found.documents) })}
        </span>
      </h2>
      <div class="measure-scroll">
        <table>
          <thead>
            <tr>
              <th>{m("label.name")}</th>
              <th class="n">{m("label.frames")}</th>
              <th>{m("label.quantity")}</th>
              {FIGURES.map((name) => (
                <th key={name} class="n">
                  {m(`label.${name}`)}
                </th>
              ))}
              <th class="n">{m("label.atMax")}</th>
              <th class="n" title={m("help.score")}>
                {m("label.score")}
              </th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <RowOf key={keyOf(row)} row={row} isPicked={keyOf(row) === picked} onPick={onPick} />
            ))}
          </tbody>
        </table>
      </div>
      {found.total_ranges > rows.length && (
        <p class="dim">{m("label.moreRows", { n: found.total_ranges - rows.length })}</p>
      )}
    </section>
  );
}

function RowOf({ row, isPicked, onPick }: { row: Row; isPicked: boolean; onPick: (row: Row) => void }) {
  return (
    <tr class={isPicked ? "picked" : ""}>
      <td>
        <button type="button" class="button quiet dense cut" aria-pressed={isPicked} onClick={() => onPick(row)}>
          {row.name}
        </button>
      </td>
      <td class="n">
        {number(row.first)}–{number(row.last)}
      </td>
      <td>
        {quantityName(row.quantity)} {row.unit && <span class="dim">({unitName(row.unit)})</span>}
      </td>
      {FIGURES.map((name) => (
        <td key={name} class="n">
          {figure(row[name])}
        </td>
      ))}
      <td class="n">{row.max_time === null ? "–" : `${number(row.max_time, 3)} s`}</td>
      <td class="n">
        {row.outlier ? (
          <span class="measure-outlier" title={m("help.score")}>
            <Icon name="warn" /> {m("label.outlier")} {figure(row.score, 2)}
          </span>
        ) : (
          figure(row.score, 2)
        )}
      </td>
    </tr>
  );
}
