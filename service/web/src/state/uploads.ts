/** Files on their way in: a queue with progress, cancel and retry. What is stored says what was found and guessed. */
import { signal } from "@preact/signals";
import { ApiError, address, ask, type Problem, type Schemas } from "../api/client";
import { w } from "../words";
import { refresh } from "./library";
import { note, refuse } from "./notes";
import { Pace, type Told } from "./pace";
import { param } from "./route";
import { loadVocabulary } from "./vocabulary";

type Receipt = Schemas["Receipt"];
export interface Upload {
  id: number;
  files: File[];
  name: string;
  state: "queued" | "sending" | "reading" | "stored" | "refused" | "cancelled";
  sent: number; // 0 to 1
  documents: { id: string; name: string; skipped: boolean; receipt: Receipt }[];
  problems: { file: string; problem: Problem }[];
  stop?: () => void;
}

export const uploads = signal<Upload[]>([]);
export const trayOpen = signal(false);
/** How fast files go, while several are on their way. */
export const pace = signal<Told | null>(null);
const PACE_TOLD = 500; // ms between two tellings
const SHOWN_EVERY = 1000; // ms between two looks at the library while files come in
const AT_ONCE = 2;
const MOST_FILES = 5000;
const READABLE = /\.(bvh|asf|amc|htr|gtr|c3d|trc|mcml|xml|zip)$/i;
let last = 0;
let measured = new Pace();
let telling = 0;
let showing = 0;

const isOver = (one: Upload): boolean => /stored|refused|cancelled/.test(one.state);
const filesIn = (some: Upload[]): number => some.reduce((sum, one) => sum + one.files.length, 0);

/** Files that are done, of how many. */
export const filesDone = (all: Upload[]): { done: number; of: number } => ({ done: filesIn(all.filter(isOver)), of: filesIn(all) });

/** Tell the pace until nothing is under way. */
function tellPace(): void {
  if (telling) return;
  measured = new Pace();
  measured.tell(filesDone(uploads.peek()).done);
  telling = window.setInterval(() => {
    const all = uploads.peek();
    if (!all.every(isOver)) return void (pace.value = measured.now(filesDone(all).of));
    window.clearInterval(telling);
    telling = 0;
    pace.value = null;
  }, PACE_TOLD);
}

/** Show what came in: at once where it was the last, else once a second for all of a folder. */
function showStored(): void {
  const show = () => {
    window.clearTimeout(showing);
    showing = 0;
    refresh();
    void loadVocabulary(true);
  };
  if (uploads.peek().every(isOver)) show();
  else if (!showing) showing = window.setTimeout(show, SHOWN_EVERY);
}

function change(id: number, more: Partial<Upload>): void {
  uploads.value = uploads.peek().map((one) => (one.id === id ? { ...one, ...more } : one));
}

/** Files in the groups that are stored together: an ASF with the AMCs of its folder, every other file by itself. */
export function grouped(files: File[]): File[][] {
  const folderOf = (file: File) => {
    const path = (file as File & { path?: string }).path ?? file.webkitRelativePath ?? "";
    return path.slice(0, path.lastIndexOf("/") + 1);
  };
  const folders = new Map<string, File[]>();
  const alone: File[][] = [];
  for (const file of files) {
    if (!/\.(asf|amc)$/i.test(file.name)) alone.push([file]);
    else folders.set(folderOf(file), [...(folders.get(folderOf(file)) ?? []), file]);
  }
  const together = [...folders.values()].flatMap((group) =>
    group.some((file) => /\.asf$/i.test(file.name)) ? [group] : group.map((file) => [file]),
  );
  return [...together, ...alone];
}

export function addFiles(all: File[]): void {
  const readable = all.filter((file) => READABLE.test(file.name));
  if (!readable.length) return note(w("noFiles"), { bad: true });
  if (readable.length > MOST_FILES) note(w("tooMany", { n: MOST_FILES }), { bad: true });
  const added = grouped(readable.slice(0, MOST_FILES)).map((files): Upload => ({
    id: ++last, files, name: files.map((file) => file.name).join(" + "), state: "queued", sent: 0, documents: [], problems: [],
  }));
  uploads.value = [...uploads.peek(), ...added];
  trayOpen.value = true;
  tellPace();
  pump();
}

export function chooseFiles(): void {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.accept = ".bvh,.asf,.amc,.htr,.c3d,.trc,.mcml,.xml,.zip";
  input.onchange = () => addFiles([...(input.files ?? [])]);
  input.click();
}

function pump(): void {
  const all = uploads.peek();
  const busy = all.filter((one) => one.state === "sending" || one.state === "reading").length;
  for (const one of all.filter((each) => each.state === "queued").slice(0, Math.max(0, AT_ONCE - busy))) send(one);
}

function send(upload: Upload): void {
  const form = new FormData();
  for (const file of upload.files) form.append("file", file, file.name);
  const project = param("project");
  if (project) form.append("project", project);
  // fetch() tells nothing of what was sent; XMLHttpRequest does.
  const request = new XMLHttpRequest();
  request.open("POST", address("/documents"));
  request.setRequestHeader("accept", "application/json");
  request.upload.onprogress = (event) => change(upload.id, { sent: event.total ? event.loaded / event.total : 0 });
  request.upload.onload = () => change(upload.id, { state: "reading", sent: 1 });
  request.onload = () => finished(upload.id, request.status, request.responseText);
  request.onerror = () => finished(upload.id, 0, "");
  request.onabort = () => { change(upload.id, { state: "cancelled" }); pump(); };
  change(upload.id, { state: "sending", sent: 0, problems: [], stop: () => request.abort() });
  request.send(form);
}

function finished(id: number, status: number, text: string): void {
  let answer: Partial<Schemas["UploadResult"]> & Problem = {};
  try {
    answer = JSON.parse(text);
  } catch {
    /* No words at all. */
  }
  if (status >= 200 && status < 300) {
    change(id, { state: answer.documents?.length ? "stored" : "refused", documents: (answer.documents ?? []) as Upload["documents"], problems: answer.problems ?? [] });
    showStored();
  } else {
    const name = uploads.peek().find((one) => one.id === id)?.name ?? "";
    const listed = (answer as { problems?: Upload["problems"] }).problems;
    change(id, { state: "refused", problems: listed?.length ? listed : [{ file: name, problem: status ? answer : { title: w("offline", { time: "" }) } }] });
  }
  measured.tell(filesDone(uploads.peek()).done);
  pump();
}

export function retry(id: number): void {
  change(id, { state: "queued" });
  tellPace();
  pump();
}

export function cancel(id: number): void {
  const one = uploads.peek().find((each) => each.id === id);
  if (one?.state === "queued") change(id, { state: "cancelled" });
  else one?.stop?.();
}

export const cancelAll = (): void => uploads.peek().forEach((one) => /queued|sending|reading/.test(one.state) && cancel(one.id));

/** Hide what an upload stored. */
export async function undoImport(upload: Upload): Promise<void> {
  for (const one of upload.documents) {
    if (one.skipped) continue;
    try {
      const { revision } = await ask("get", "/documents/{id}", { path: { id: one.id } });
      await ask("delete", "/documents/{id}", { path: { id: one.id }, match: revision });
    } catch (error) {
      refuse(error);
    }
  }
  uploads.value = uploads.peek().filter((one) => one.id !== upload.id);
  refresh();
  note(w("deleted", { n: upload.documents.length }));
}

/** Write the answer to a guess into documents. */
export async function confirmFact(documents: string[], change: { unit?: string; up?: string; frame_time?: string }): Promise<boolean> {
  try {
    for (const id of documents) {
      const detail = await ask("get", "/documents/{id}", { path: { id } });
      await ask("patch", "/documents/{id}", { path: { id }, body: change as never, match: detail.revision });
    }
    refresh();
    return true;
  } catch (error) {
    if (error instanceof ApiError || error instanceof Error) refuse(error);
    return false;
  }
}

/** All files of what was dropped, folders walked. */
export async function filesOf(transfer: DataTransfer): Promise<File[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry): entry is FileSystemEntry => Boolean(entry));
  if (!entries.length) return [...transfer.files];
  const found: File[] = [];
  const walk = async (entry: FileSystemEntry): Promise<void> => {
    if (entry.isFile) {
      const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
      found.push(Object.assign(file, { path: entry.fullPath }));
      return;
    }
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    // A reader answers a hundred entries at a time.
    for (;;) {
      const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
      if (!some.length) return;
      for (const one of some) await walk(one);
    }
  };
  for (const entry of entries) await walk(entry);
  return found;
}
