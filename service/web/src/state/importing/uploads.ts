/** Files on their way in: a queue with progress, cancel and retry. What is stored says what was found and guessed. */
import { signal } from "@preact/signals";
import { ApiError, address, ask, fetched, type Problem, type Schemas } from "../../api/client";
import { w } from "../../words";
import { folderOf, type Missed } from "./dropped";
import { refresh, removeDocuments } from "../library/library";
import { formatBeside, isOf, isOneClip, isRead, readExtensions } from "../session/formats";
import { note, refuse } from "../session/notes";
import { Pace, type Told } from "./pace";
import { param } from "../session/route";
import { loadVocabulary } from "../library/vocabulary";

type Receipt = Schemas["Receipt"];
export interface Upload {
  id: number;
  files: File[];
  name: string;
  state: "queued" | "sending" | "reading" | "stored" | "refused" | "cancelled";
  sent: number; // 0 to 1
  documents: { id: string; name: string; file: string; skipped: boolean; receipt: Receipt }[];
  problems: { file: string; problem: Problem }[];
  stop?: () => void;
  /** Whether its beginning was looked at before. */
  asked?: boolean;
}

export const uploads = signal<Upload[]>([]);
/** Whether the table of the import is shown; else one line tells of it. */
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
/** Of a longer file of an unknown kind the beginning is asked about first. */
const MOST_UNKNOWN = 8 << 20; // bytes
const BEGINNING = 64 << 10; // bytes
let last = 0;
let measured = new Pace();
let telling = 0;
let showing = 0;
let resting = 0; // a timer, while the server is too busy

export const isOver = (one: Upload): boolean => /stored|refused|cancelled/.test(one.state);
const filesIn = (some: Upload[]): number => some.reduce((sum, one) => sum + Math.max(1, one.files.length), 0);

/** Files that are done, of how many. */
export const filesDone = (all: Upload[]): { done: number; of: number } => ({
  done: filesIn(all.filter(isOver)),
  of: filesIn(all),
});

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
  const folders = new Map<string, File[]>();
  const alone: File[][] = [];
  const put = (key: string, file: File) => folders.set(key, [...(folders.get(key) ?? []), file]);
  const beside = new Set(files.flatMap((file) => formatBeside(file.name) ?? []));
  for (const file of files) {
    const format = formatBeside(file.name) ?? [...beside].find((one) => isOf(file.name, one));
    if (/\.(asf|amc)$/i.test(file.name)) put(folderOf(file), file);
    else if (format) put(format.name, file);
    else alone.push([file]);
  }
  const together = [...folders.values()].flatMap((group) =>
    group.some((file) => /\.asf$/i.test(file.name) || formatBeside(file.name)) ? [group] : group.map((file) => [file]),
  );
  return [...together, ...alone];
}

/** One row for each file or group, of unknown kinds too: the server says what they are. missed: rows of what cannot be sent. */
export function rowsOf(all: File[], missed: Missed[] = []): Upload[] {
  const left = all.length - MOST_FILES;
  const untaken =
    left > 0
      ? [
          {
            file: w("label.filesMore", { n: left }),
            problem: { title: w("help.tooMany", { n: MOST_FILES }), remedy: w("help.tooManyHelp") },
          },
        ]
      : [];
  const row = (more: Pick<Upload, "files" | "name" | "state" | "problems">): Upload => ({
    id: ++last,
    sent: 0,
    documents: [],
    ...more,
  });
  return [
    ...grouped(all.slice(0, MOST_FILES)).map((files) =>
      row({ files, name: files.map((file) => file.name).join(" + "), state: "queued", problems: [] }),
    ),
    ...[...missed, ...untaken].map((one) => row({ files: [], name: one.file, state: "refused", problems: [one] })),
  ];
}

export function addFiles(all: File[], missed: Missed[] = []): void {
  const added = rowsOf(all, missed);
  if (!added.length) {
    note(w("error.noFiles"), { bad: true });
    return;
  }
  uploads.value = [...uploads.peek(), ...added];
  trayOpen.value = true;
  tellPace();
  pump();
}

export function chooseFiles(): void {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.accept = readExtensions().join(",");
  input.onchange = () => addFiles([...(input.files ?? [])]);
  input.click();
}

/** The next of those that wait that go in one request: one upload, or short single files of different names. */
export function together(queued: Upload[]): Upload[] {
  const batch: Upload[] = [];
  let bytes = 0;
  for (const one of queued) {
    const size = one.files[0]!.size;
    const isSingle = one.files.length === 1 && isOneClip(one.name);
    const fits = isSingle && bytes + size <= BYTES_TOGETHER && !batch.some((other) => other.name === one.name);
    if (batch.length && !fits) break;
    batch.push(one);
    bytes += size;
    if (!isSingle || batch.length === MOST_TOGETHER) break;
  }
  return batch;
}

type Outcome = Pick<Upload, "state" | "documents" | "problems">;

/** What became of each upload of a request. Documents come in the order of the files, but for those with a problem; where one file
 * held several, or none, their names tell which. */
export function outcomes(batch: Upload[], documents: Upload["documents"], problems: Upload["problems"]): Outcome[] {
  const isBad = (one: Upload) => problems.some(({ file }) => file === one.name);
  const good = batch.filter((one) => !isBad(one));
  const inOrder = good.length === documents.length;
  const left = [...documents];
  const ofName = (one: Upload) => left.filter(({ name }) => one.name.startsWith(`${name}.`));
  return batch.map((one) => {
    const own = batch.length === 1 ? documents : inOrder ? (isBad(one) ? [] : left.splice(0, 1)) : ofName(one);
    const its = batch.length === 1 ? problems : problems.filter(({ file }) => file === one.name);
    const silent = !own.length && !its.length;
    return {
      state: own.length ? "stored" : "refused",
      documents: own,
      problems: silent
        ? [{ file: one.name, problem: { title: w("error.noWord"), remedy: w("error.noWordHelp") } }]
        : its,
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
    const [first] = batch[0]!.files;
    if (!isRead(first!.name) && first!.size > MOST_UNKNOWN && !batch[0]!.asked) void askFirst(batch[0]!, first!);
    else send(batch);
  }
}

/** Ask what a long file of an unknown kind is before it is sent. */
async function askFirst(one: Upload, file: File): Promise<void> {
  const stop = new AbortController();
  change(one.id, { state: "reading", problems: [], stop: () => stop.abort() });
  const form = new FormData();
  form.append("file", file.slice(0, BEGINNING), file.name);
  let problems: Upload["problems"] = [];
  try {
    const answer = await fetched(address("/inspect"), { method: "POST", body: form, signal: stop.signal });
    const looked = ((await answer.json()) as Schemas["InspectResult"]).problems as Upload["problems"];
    problems = looked.filter(({ problem }) => problem.type?.endsWith("#unsupported-error"));
  } catch (error) {
    if (stop.signal.aborted) {
      pump();
      return;
    }
    problems = [
      {
        file: file.name,
        problem: error instanceof ApiError ? error.problem : { title: w("error.offline", { time: "" }) },
      },
    ];
  }
  change(one.id, problems.length ? { state: "refused", problems } : { state: "queued", asked: true });
  measured.tell(filesDone(uploads.peek()).done);
  pump();
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
    resting ||= window.setTimeout(
      () => {
        resting = 0;
        pump();
      },
      1000 * Number(request.getResponseHeader("retry-after") ?? 5),
    );
    return;
  }
  const isDone = request.status >= 200 && request.status < 300;
  const listed = (answer as { problems?: Upload["problems"] }).problems ?? [];
  const problem = request.status ? answer : { title: w("error.offline", { time: "" }) };
  const problems = isDone || listed.length ? listed : batch.map((one) => ({ file: one.name, problem }));
  const became = outcomes(batch, isDone ? (answer.documents ?? []) : [], problems);
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
  const others =
    one.state === "queued"
      ? []
      : all.filter((each) => each.id !== id && each.stop === one.stop && /sending|reading/.test(each.state));
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

/** Delete a clip that an upload stored. */
export async function undoImport(upload: Upload, id: string): Promise<void> {
  await removeDocuments([id]);
  const documents = upload.documents.filter((one) => one.id !== id);
  change(upload.id, { documents });
  if (!documents.length && !upload.problems.length)
    uploads.value = uploads.peek().filter((one) => one.id !== upload.id);
}

/** Write the answer to a guess into documents. */
export async function confirmFact(
  documents: string[],
  change: { unit?: string; up?: string; frame_time?: string },
): Promise<boolean> {
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
