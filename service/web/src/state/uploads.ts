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
// Short files share a request: each by itself they take five times as long.
const MOST_TOGETHER = 32;
const BYTES_TOGETHER = 8 << 20;
const MOST_FILES = 5000;
const READABLE = /\.(bvh|asf|amc|htr|gtr|c3d|trc|mcml|xml|zip)$/i;
let last = 0;
let measured = new Pace();
let telling = 0;
let showing = 0;
let resting = 0; // a timer, while the server is too busy

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

/** The next of those that wait that go in one request: one upload, or short single files of different names. */
export function together(queued: Upload[]): Upload[] {
  const batch: Upload[] = [];
  let bytes = 0;
  for (const one of queued) {
    const size = one.files[0]!.size;
    const isSingle = one.files.length === 1 && !/\.(asf|amc|zip)$/i.test(one.name);
    const fits = isSingle && bytes + size <= BYTES_TOGETHER && !batch.some((other) => other.name === one.name);
    if (batch.length && !fits) break;
    batch.push(one);
    bytes += size;
    if (!isSingle || batch.length === MOST_TOGETHER) break;
  }
  return batch;
}

type Outcome = Pick<Upload, "state" | "documents" | "problems">;

/** What became of each upload of a request. Documents come in the order of the files, but for those with a problem. */
export function outcomes(batch: Upload[], documents: Upload["documents"], problems: Upload["problems"]): Outcome[] {
  const isBad = (one: Upload) => problems.some(({ file }) => file === one.name);
  const left = [...documents];
  return batch.map((one) => {
    const own = batch.length === 1 ? documents : isBad(one) ? [] : left.splice(0, 1);
    return {
      state: own.length ? "stored" : "refused",
      documents: own,
      problems: batch.length === 1 ? problems : problems.filter(({ file }) => file === one.name),
    };
  });
}

function pump(): void {
  if (resting) return;
  const all = uploads.peek();
  const busy = new Set(all.filter((one) => one.state === "sending" || one.state === "reading").map((one) => one.stop));
  let queued = all.filter((one) => one.state === "queued");
  for (let free = AT_ONCE - busy.size; free > 0 && queued.length; free--) {
    const batch = together(queued);
    queued = queued.slice(batch.length);
    send(batch);
  }
}

function send(batch: Upload[]): void {
  const form = new FormData();
  for (const file of batch.flatMap((one) => one.files)) form.append("file", file, file.name);
  const project = param("project");
  if (project) form.append("project", project);
  const all = (more: Partial<Upload>) => batch.forEach((one) => change(one.id, more));
  // fetch() tells nothing of what was sent; XMLHttpRequest does.
  const request = new XMLHttpRequest();
  request.open("POST", address("/documents"));
  request.setRequestHeader("accept", "application/json");
  request.upload.onprogress = (event) => all({ sent: event.total ? event.loaded / event.total : 0 });
  request.upload.onload = () => all({ state: "reading", sent: 1 });
  request.onload = () => finished(batch, request);
  request.onerror = () => finished(batch, request);
  request.onabort = pump;
  all({ state: "sending", sent: 0, problems: [], stop: () => request.abort() });
  request.send(form);
}

function finished(batch: Upload[], request: XMLHttpRequest): void {
  let answer: Partial<Schemas["UploadResult"]> & Problem = {};
  try {
    answer = JSON.parse(request.responseText);
  } catch {
    /* No words at all. */
  }
  if (/#(busy|share)-error$/.test(answer.type ?? "")) {
    batch.forEach((one) => change(one.id, { state: "queued" }));
    resting ||= window.setTimeout(() => { resting = 0; pump(); }, 1000 * Number(request.getResponseHeader("retry-after") ?? 5));
    return;
  }
  const isDone = request.status >= 200 && request.status < 300;
  const listed = (answer as { problems?: Upload["problems"] }).problems ?? [];
  const problem = request.status ? answer : { title: w("offline", { time: "" }) };
  const problems = isDone || listed.length ? listed : batch.map((one) => ({ file: one.name, problem }));
  const became = outcomes(batch, isDone ? ((answer.documents ?? []) as Upload["documents"]) : [], problems);
  batch.forEach((one, index) => change(one.id, became[index]!));
  if (isDone) showStored();
  measured.tell(filesDone(uploads.peek()).done);
  pump();
}

export function retry(id: number): void {
  change(id, { state: "queued" });
  tellPace();
  pump();
}

export function cancel(id: number): void {
  const all = uploads.peek();
  const one = all.find((each) => each.id === id);
  if (!one) return;
  // Of what was not sent whole nothing is stored: others of its request go again.
  const others = one.state === "queued" ? [] : all.filter((each) => each.id !== id && each.stop === one.stop && /sending|reading/.test(each.state));
  const stop = one.state === "queued" ? undefined : one.stop;
  change(id, { state: "cancelled" });
  others.forEach((each) => change(each.id, { state: each.state === "sending" ? "queued" : "cancelled" }));
  stop?.();
}

export function cancelAll(): void {
  const left = uploads.peek().filter((one) => !isOver(one));
  left.forEach((one) => change(one.id, { state: "cancelled" }));
  new Set(left.map((one) => one.stop)).forEach((stop) => stop?.());
}

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
