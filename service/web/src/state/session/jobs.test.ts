// @vitest-environment happy-dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { cancelJob, dropJob, ended, followKept, jobs, placeOf, runAnalysis, startAnalysis, type Job } from "./jobs";
import { notes } from "./notes";

const job = (more: Partial<Job> = {}): Job =>
  ({ id: "1", analysis: "beats", state: "running", share: 0, result: null, problem: null, ...more }) as Job;

/** The stream of events of a job, as the server would send them. */
class Stream extends EventTarget {
  static all: Stream[] = [];
  closed = false;
  constructor(readonly url: string) {
    super();
    Stream.all.push(this);
  }
  close(): void {
    this.closed = true;
  }
  tell(kind: "progress" | "end", told: Job): void {
    this.dispatchEvent(new MessageEvent(kind, { data: JSON.stringify(told) }));
  }
}
const last = (): Stream => Stream.all.at(-1)!;

let answers: (() => Response)[] = [];
const asked: string[] = [];
const json =
  (body: unknown, status = 200) =>
  () =>
    new Response(JSON.stringify(body), { status, headers: { "content-type": "application/json" } });

beforeEach(() => {
  jobs.value = [];
  notes.value = [];
  sessionStorage.clear();
  Stream.all = [];
  asked.length = 0;
  vi.stubGlobal("EventSource", Stream);
  vi.stubGlobal("fetch", (url: string, options?: RequestInit) => {
    asked.push(`${options?.method ?? "GET"} ${new URL(url, "http://x").pathname}`);
    return Promise.resolve(answers.shift()!());
  });
});
afterEach(() => vi.unstubAllGlobals());

describe("an analysis", () => {
  it("is followed until it ends, and answers with its result", async () => {
    answers = [json(job())];
    let started: Job | null = null;
    const result = runAnalysis("beats", {}, (one) => (started = one));
    await vi.waitFor(() => expect(started).not.toBeNull());
    last().tell("progress", job({ share: 0.5 }));
    expect(jobs.value.map((one) => one.share)).toEqual([0.5]);
    last().tell("end", job({ state: "done", result: "r" }));
    expect(await result).toBe("r");
    expect(last().closed).toBe(true);
  });

  it("ends with the problem that the server told", async () => {
    answers = [json(job())];
    const running = await startAnalysis("beats", {});
    const end = ended(running);
    last().tell("end", job({ state: "failed", problem: { title: "No beats", status: 409 } as Job["problem"] }));
    await expect(end).rejects.toThrow("No beats");
    // Who asks late is told the same.
    await expect(ended(running)).rejects.toThrow("No beats");
  });

  it("ends as an aborted request where it is cancelled, and needs no stream where it is over at once", async () => {
    answers = [json(job({ state: "cancelled" }))];
    await expect(runAnalysis("beats", {})).rejects.toMatchObject({ name: "AbortError" });
    expect(Stream.all).toEqual([]);
  });
});

describe("the list of jobs", () => {
  it("has the newest first, twelve at most, and each in its place when it moves on", async () => {
    for (let id = 0; id < 14; id++) {
      answers = [json(job({ id: String(id) }))];
      await startAnalysis("beats", {});
    }
    expect(jobs.value.map((one) => one.id)).toEqual(["13", "12", "11", "10", "9", "8", "7", "6", "5", "4", "3", "2"]);
    Stream.all[8]!.tell("progress", job({ id: "8", share: 0.3 }));
    expect(jobs.value.findIndex((one) => one.id === "8")).toBe(5);
  });

  it("is taken up after a reload, without those that are gone", async () => {
    for (const id of ["a", "b"]) {
      answers = [json(job({ id }))];
      await startAnalysis("beats", {});
    }
    dropJob("b");
    const before = sessionStorage.getItem("mcml.jobs")!;
    sessionStorage.setItem("mcml.jobs", JSON.stringify(["gone", ...(JSON.parse(before) as string[])]));
    jobs.value = [];
    answers = [json(job({ id: "a", state: "done" })), json({ title: "Not found", status: 404 }, 404)];
    followKept();
    await vi.waitFor(() => expect(jobs.value.map((one) => one.id)).toEqual(["a"]));
    expect(asked.slice(-2)).toEqual(["GET /api/v1/jobs/a", "GET /api/v1/jobs/gone"]);
  });

  it("says why a job could not be cancelled", async () => {
    answers = [json({ title: "Not yours", status: 403 }, 403)];
    await cancelJob(job());
    expect(asked).toEqual(["DELETE /api/v1/jobs/1"]);
    expect(notes.value.map((one) => one.bad)).toEqual([true]);
  });
});

it("a result is looked at on the page of its analysis", () => {
  expect(["reach", "expression", "motion-graph", "beats"].map((one) => placeOf(one, "1"))).toEqual([
    "/reach/1",
    "/faces/1",
    "/dance/1",
    "/results/1",
  ]);
});
