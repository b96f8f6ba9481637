/** The files of an import by name: what became of each, why, and what can be done. */
import { useState } from "preact/hooks";
import { warningsOf, type Line } from "../../../state/importing/report";
import { cancel, isOver, retry, undoImport, type Upload } from "../../../state/importing/uploads";
import { Icon } from "../../../ui/icons";
import { MiddleCut } from "../../../ui/MiddleCut";
import { w } from "../../../words";
import { i } from "../words";
import { ReceiptView } from "./ReceiptView";
import { Refusal } from "./Refusal";

const ROWS = 200;
const ICONS = {
  stored: "check",
  existing: "check",
  warned: "warn",
  refused: "warn",
  underway: null,
  cancelled: null,
} as const;

export function ReportTable({
  lines,
  alone,
}: {
  lines: Line[];
  /** Whether its one file shows its findings at once. */ alone: boolean;
}) {
  const [most, setMost] = useState(ROWS);
  return (
    <div class="report">
      <table aria-label={w("label.receipts")}>
        <thead>
          <tr>
            <th>{i("label.file")}</th>
            <th>{i("label.outcome")}</th>
            <th>{i("label.message")}</th>
            <th>
              <span class="unseen">{i("label.actions")}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {lines.slice(0, most).map((line) => (
            <Row key={line.key} line={line} alone={alone} />
          ))}
        </tbody>
      </table>
      {lines.length > most && (
        <button type="button" class="button dense" onClick={() => setMost(most + ROWS)}>
          {w("button.rowsMore", { n: lines.length - most })}
        </button>
      )}
    </div>
  );
}

function Row({ line, alone }: { line: Line; alone: boolean }) {
  const [open, setOpen] = useState(alone);
  const { folder, outcome, upload, document, problem } = line;
  const file = nameOf(line);
  const icon = ICONS[outcome];
  return (
    <>
      <tr data-outcome={outcome}>
        <th scope="row" title={folder + file}>
          <MiddleCut text={file} />
          {folder && <span class="dim cut block">{folder}</span>}
        </th>
        <td class="outcome">
          <span class={`state ${outcome}`}>{icon && <Icon name={icon} />}</span>
          <OutcomeOf line={line} />
        </td>
        <td class="message">
          {problem && <Refusal refused={problem} />}
          {document && <Findings document={document} />}
        </td>
        <td>
          <div class="row report-actions">
            {!isOver(upload) && (
              <button
                type="button"
                class="button quiet icon dense"
                aria-label={i("button.cancelFile", { name: file })}
                onClick={() => cancel(upload.id)}
              >
                <Icon name="close" />
              </button>
            )}
            {upload.files.length > 0 && !upload.documents.length && isOver(upload) && (
              <button type="button" class="button dense" onClick={() => retry(upload.id)}>
                {w("button.retry")}
              </button>
            )}
            {document && (
              <button type="button" class="button quiet dense" aria-expanded={open} onClick={() => setOpen(!open)}>
                {i("label.findings")}
              </button>
            )}
            {document && (
              <a class="button dense" href={`/clips/${document.id}`}>
                {w("button.open")}
              </a>
            )}
          </div>
        </td>
      </tr>
      {document && open && (
        <tr class="findings">
          <td colSpan={4}>
            <ReceiptView receipt={document.receipt} documents={[document.id]} />
            {!document.skipped && (
              <p>
                <button type="button" class="button dense" onClick={() => void undoImport(upload, document.id)}>
                  {w("button.undoImport")}
                </button>
              </p>
            )}
          </td>
        </tr>
      )}
    </>
  );
}

const FEW = 3;

/** Of many files that become one clip or several, the first is named until it is known which. */
function nameOf({ file, upload, document, problem }: Line): string {
  const [first] = upload.files;
  if (document || problem || !first || upload.files.length <= FEW) return file;
  return w("label.filesAnd", { name: first.name, n: upload.files.length - 1 });
}

function OutcomeOf({ line: { outcome, upload, document } }: { line: Line }) {
  if (upload.state === "sending")
    return <progress value={upload.sent} max={1} aria-label={`${w("label.sending")}: ${upload.name}`} />;
  if (outcome === "underway") return <span class="dim">{w(`label.${upload.state as "queued" | "reading"}`)}</span>;
  return <span>{document?.skipped ? w("label.skippedTwin") : i(`label.${outcome}`)}</span>;
}

/** The first of the warnings; all of them are under the findings. */
function Findings({ document }: { document: Upload["documents"][number] }) {
  const [first, ...more] = warningsOf(document);
  return (
    <>
      {document.receipt.twins.length > 0 && !document.skipped && <p>{w("help.twin")}</p>}
      {first && (
        <p>
          {first.what} {first.at && <span class="dim">{first.at}</span>}{" "}
          {more.length > 0 && <span class="dim">{i("label.moreWarnings", { n: more.length })}</span>}
        </p>
      )}
    </>
  );
}
