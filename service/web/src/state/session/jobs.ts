/** Long work that this window started or was told of: followed until it ends, kept over a reload. */
import { signal } from "@preact/signals";
import { ApiError, ask, get, type Schemas } from "../../api/client";
import { refuse } from "./notes";

export type Job = Schemas["Job"];

const KEPT = "mcml.jobs";
const MOST = 12;

/** The newest first. */
export const jobs = signal<Job[]>([]);

const waiting = new Map<string, ((job: Job) => void)[]>();
const followed = new Map<string, EventSource>();
/** Whether a job has ended. */
export const isOver = (job: Job): boolean => job.state !== "waiting" && job.state !== "running";

function heard(job: Job): void {
  const rest = jobs.peek().filter((one) => one.id !== job.id);
  const place = jobs.peek().findIndex((one) => one.id === job.id);
  jobs.value = place < 0 ? [job, ...rest].slice(0, MOST) : [...rest.slice(0, place), job, ...rest.slice(place)];
  sessionStorage.setItem(KEPT, JSON.stringify(jobs.peek().map((one) => one.id)));
  if (!isOver(job)) return;
  followed.get(job.id)?.close();
  followed.delete(job.id);
  for (const tell of waiting.get(job.id) ?? []) tell(job);
  waiting.delete(job.id);
}

function follow(job: Job): void {
  heard(job);
  if (isOver(job) || followed.has(job.id)) return;
  const source = new EventSource(`/api/v1/jobs/${job.id}/events`);
  followed.set(job.id, source);
  const tell = (event: MessageEvent<string>) => heard(JSON.parse(event.data) as Job);
  source.addEventListener("progress", tell as EventListener);
  source.addEventListener("end", tell as EventListener);
}

/** Start an analysis. ApiError for what is wrong on sight. */
export async function startAnalysis(analysis: string, body: object): Promise<Job> {
  const job = (await ask("post", `/analyses/${analysis}` as never, { body: body })) as unknown as Job;
  follow(job);
  return job;
}

/** The job when it has ended. Refused with the problem that it ended with; cancelled jobs refuse as aborted requests do. */
export async function ended(job: Job): Promise<Job> {
  const last = await new Promise<Job>((resolve) => {
    const now = jobs.peek().find((one) => one.id === job.id) ?? job;
    if (isOver(now)) resolve(now);
    else waiting.set(job.id, [...(waiting.get(job.id) ?? []), resolve]);
  });
  if (last.state === "done") return last;
  if (last.state === "cancelled") throw new DOMException("cancelled", "AbortError");
  throw new ApiError(last.problem?.status ?? 422, last.problem ?? { title: last.state });
}

/** Run an analysis to its end: the id of its result. */
export async function runAnalysis(
  analysis: string,
  body: object,
  started: (job: Job) => void = () => undefined,
): Promise<string> {
  const job = await startAnalysis(analysis, body);
  started(job);
  return (await ended(job)).result!;
}

export async function cancelJob(job: Job): Promise<void> {
  try {
    await ask("delete", "/jobs/{id}", { path: { id: job.id } });
  } catch (error) {
    refuse(error);
  }
}

/** Leave a job that has ended out of the list: it answered a question of a moment. */
export function dropJob(id: string): void {
  jobs.value = jobs.peek().filter((one) => one.id !== id);
  sessionStorage.setItem(KEPT, JSON.stringify(jobs.peek().map((one) => one.id)));
}

/** Take up what was followed before a reload. */
export function followKept(): void {
  const ids = JSON.parse(sessionStorage.getItem(KEPT) ?? "[]") as string[];
  for (const id of ids.reverse()) get("/jobs/{id}", { path: { id } }).then(follow, () => undefined);
}

/** Where a result of an analysis is looked at. */
export function placeOf(analysis: string, result: string): string {
  const pages: Record<string, string> = {
    reach: "reach",
    expression: "faces",
    dance: "dance",
    "motion-graph": "dance",
  };
  return pages[analysis] ? `/${pages[analysis]}/${result}` : `/results/${result}`;
}
