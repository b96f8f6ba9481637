/** The report as a file, or on the clipboard. */
import { reportAsCsv, type Line } from "../../../state/importing/report";
import { copyText } from "../../../state/session/notes";
import { saveBlob } from "../../../ui/exporting/saveBlob";
import { i } from "../words";

export function CopyReport({ lines }: { lines: Line[] }) {
  const text = () =>
    reportAsCsv(
      lines,
      (outcome) => i(`label.${outcome}`),
      (id) => `${location.origin}/clips/${id}`,
    );
  return (
    <>
      <button type="button" class="button dense" onClick={() => void copyText(text(), i("label.reportCopied"))}>
        {i("button.copyReport")}
      </button>
      <button
        type="button"
        class="button dense"
        // A byte order mark: Excel reads UTF-8 by it.
        onClick={() => saveBlob(new Blob(["\ufeff", text()], { type: "text/csv" }), "import.csv")}
      >
        {i("button.saveReport")}
      </button>
    </>
  );
}
