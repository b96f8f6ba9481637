/** Results of many clips in one table, problems and outliers first, and the same as a file. */
import type { Schemas } from "../../api/client";
import { saveBlob } from "../../ui/exporting/saveBlob";
import { Icon } from "../../ui/icons";
import { number, w } from "../../words";

type Data = Schemas["RetargetTable"];
type Row = Schemas["RetargetRow"];
const COLUMNS = ["limbs", "hips", "shoulders", "trunk", "head", "foot_slide"] as const;
const HEADS = {
  limbs: "label.limbs",
  hips: "label.hipLine",
  shoulders: "label.shoulderLine",
  trunk: "label.trunk",
  head: "label.headPart",
  foot_slide: "label.footSlide",
} as const;
const OUTLIER = 3; // robust standard deviations above the median

export function Table({ table }: { table: Data | null }) {
  if (!table) return null;
  return (
    <div class="many-table">
      <table>
        <thead>
          <tr>
            <th>{w("label.name")}</th>
            {COLUMNS.map((one) => (
              <th key={one} class="n">
                {w(HEADS[one])} ({one === "foot_slide" ? "cm/s" : "°"})
              </th>
            ))}
            <th>{w("label.remarks")}</th>
          </tr>
        </thead>
        <tbody>
          {table.rows.map((row) => (
            <tr key={row.source}>
              <td>
                <span class="row">
                  <span class={`state ${row.problem ? "refused" : "stored"}`}>
                    <Icon name={row.problem ? "warn" : "check"} />
                  </span>
                  <a class="cut" href={`/clips/${row.document ?? row.source}`}>
                    {row.name}
                  </a>
                </span>
              </td>
              {COLUMNS.map((one) => (
                <td key={one} class="n">
                  {row[one] === null || row[one] === undefined ? "–" : number(row[one], 1)}
                </td>
              ))}
              <td class="remarks">
                {(row.deviation ?? 0) > OUTLIER && <span class="chip guess">{w("label.outlier")}</span>}{" "}
                {row.problem ?? row.warnings.join("; ")}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function SaveTable({ table, target }: { table: Data | null; target: string }) {
  if (!table) return null;
  return (
    <button type="button" class="button" onClick={() => saveTable(table, target)}>
      {w("button.saveTable")}
    </button>
  );
}

function saveTable(table: Data, target: string): void {
  const head = ["name", "source", "document", ...COLUMNS, "deviation", "warnings", "problem"] as const;
  const cell = (row: Row, name: (typeof head)[number]) => {
    const value = row[name];
    return Array.isArray(value) ? value.join("; ") : String(value ?? "");
  };
  const lines = [head.join(","), ...table.rows.map((row) => head.map((name) => quoted(cell(row, name))).join(","))];
  saveBlob(new Blob([lines.join("\r\n") + "\r\n"], { type: "text/csv" }), `${target} retargeting.csv`);
}

/** A cell of CSV that no spreadsheet runs as a formula. */
function quoted(text: string): string {
  const safe = /^[=+@\t\r-]/.test(text) && !Number.isFinite(Number(text)) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}
