/** What became of the files of an import: one line for each clip and each problem, with its outcome. */
import type { Schemas } from "../../api/client";
import { folderOf } from "./dropped";
import { isOver, type Upload } from "./uploads";

type Imported = Upload["documents"][number];
export type Outcome = "underway" | "refused" | "warned" | "existing" | "stored" | "cancelled";

/** In the order of the table once all files are done: problems first. */
export const OUTCOMES: readonly Outcome[] = ["underway", "refused", "warned", "existing", "stored", "cancelled"];

export interface Line {
  key: string;
  /** Name without folders, and the folders, "" at the top. */
  file: string;
  folder: string;
  outcome: Outcome;
  upload: Upload;
  document?: Imported;
  problem?: Upload["problems"][number];
}

/** Notices that ask for a look: guesses, repairs and warnings. */
export const warningsOf = ({ receipt }: Imported): Schemas["NoticeLine"][] =>
  receipt.notices.filter((one) => one.kind !== "note");

function outcomeOf(document: Imported): Outcome {
  if (document.skipped || document.receipt.twins.length) return "existing";
  return warningsOf(document).length ? "warned" : "stored";
}

/** The folders of a path, and the name behind them. */
function split(path: string): [folder: string, file: string] {
  const cut = path.lastIndexOf("/") + 1;
  return [path.slice(0, cut), path.slice(cut)];
}

/** Lines of an upload: of each clip and problem it became, or one of the upload while there are none. */
export function linesOf(upload: Upload): Line[] {
  const above = upload.files[0] ? folderOf(upload.files[0]) : "";
  const line = (key: string, path: string, outcome: Outcome, more: Partial<Line> = {}): Line => {
    const [folder, file] = split(path);
    return { key: `${upload.id}/${key}`, file, folder: above + folder, outcome, upload, ...more };
  };
  if (!isOver(upload)) return [line("", upload.name, "underway")];
  if (upload.state === "cancelled") return [line("", upload.name, "cancelled")];
  return [
    ...upload.problems.map((problem, at) => line(`problem ${at}`, problem.file, "refused", { problem })),
    ...upload.documents.map((document) => line(document.id, document.file, outcomeOf(document), { document })),
  ];
}

/** The lines of all uploads, the newest upload first; by outcome once all are done. */
export function reportOf(all: readonly Upload[]): Line[] {
  const lines = all.toReversed().flatMap(linesOf);
  if (lines.some((one) => one.outcome === "underway")) return lines;
  return OUTCOMES.flatMap((outcome) => lines.filter((one) => one.outcome === outcome));
}

export function countOutcomes(lines: readonly Line[]): Map<Outcome, number> {
  const counts = new Map<Outcome, number>();
  for (const { outcome } of lines) counts.set(outcome, (counts.get(outcome) ?? 0) + 1);
  return counts;
}

/** The clips that the import stored. */
export const storedIn = (lines: readonly Line[]): string[] =>
  lines.flatMap(({ document }) => (document && !document.skipped ? [document.id] : []));

/** Where and why a file was refused, and how to mend it; texts are "" where nothing is known. */
export function reasonOf({ problem }: Upload["problems"][number]) {
  const { where, title, detail, remedy } = problem;
  return {
    line: where?.line ? String(where.line) : "",
    element: where?.element ?? "",
    title: title ?? "",
    detail: detail && detail !== title ? detail : "",
    remedy: remedy ?? "",
  };
}

/** A value of a table as RFC 4180 writes it. A leading apostrophe keeps spreadsheets from running texts as formulas. */
function cell(value: string): string {
  const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : value;
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** The report as CSV (RFC 4180). named: an outcome in words; address: where a clip opens. */
export function reportAsCsv(
  lines: readonly Line[],
  named: (outcome: Outcome) => string,
  address: (id: string) => string,
): string {
  const rows = lines.map((line) => {
    const reason = line.problem && reasonOf(line.problem);
    const notices = line.document ? warningsOf(line.document) : [];
    return [
      line.folder + line.file,
      named(line.outcome),
      line.document?.name ?? "",
      line.document ? address(line.document.id) : "",
      reason?.line ?? "",
      reason
        ? [reason.title, reason.detail].filter(Boolean).join(" ")
        : notices.map(({ what, at }) => [what, at].filter(Boolean).join(", ")).join("; "),
      reason?.remedy ?? "",
    ];
  });
  const head = ["file", "outcome", "clip", "address", "line", "message", "remedy"];
  return [head, ...rows].map((row) => `${row.map(cell).join(",")}\r\n`).join("");
}
