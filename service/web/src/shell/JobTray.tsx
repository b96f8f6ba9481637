/** Long work: what runs, how far it is, its way back when it has ended. */
import { entryOf } from "../lists";
import { useEffect, useRef, useState } from "preact/hooks";
import { cancelJob, isOver, jobs, placeOf, type Job } from "../state/session/jobs";
import { rowOf } from "../pages";
import { note } from "../state/session/notes";
import { go, route } from "../state/session/route";
import { Icon } from "../ui/icons";
import { stageOf } from "../ui/analyses/titles";
import { w, type Word } from "../words";

const running = (job: Job): boolean => !isOver(job);

export function JobTray() {
  const [open, setOpen] = useState(false);
  const box = useRef<HTMLSpanElement>(null);
  const seen = useRef(new Set<string>());
  const list = jobs.value;
  const active = list.filter(running);
  useEffect(() => {
    for (const job of list) {
      if (running(job)) seen.current.add(job.id);
      // Who waits for it on its page sees it there.
      else if (seen.current.delete(job.id) && job.state === "done" && job.result && !waitedFor()) {
        const place = placeOf(job.analysis, job.result);
        note(w("label.jobEnded", { name: job.name ?? job.analysis }), {
          action: { text: w("button.openResult"), run: () => go(place) },
        });
      }
    }
  }, [list]);
  useEffect(() => {
    if (!open) return;
    const outside = (event: PointerEvent) => {
      if (!box.current?.contains(event.target as Node)) setOpen(false);
    };
    addEventListener("pointerdown", outside);
    return () => removeEventListener("pointerdown", outside);
  }, [open]);
  if (!list.length) return null;
  return (
    <span
      class="menu"
      ref={box}
      onKeyDown={(event) => {
        if (event.key === "Escape") setOpen(false);
      }}
    >
      <button type="button" class="chip" aria-expanded={open} onClick={() => setOpen(!open)}>
        {w("label.jobs")} {active.length || ""}
        {active[0] && <progress value={active[0].share} aria-label={w("label.jobs")} />}
      </button>
      {open && (
        <ul class="menu-list right job-tray" aria-label={w("label.jobs")}>
          {list.map((job) => (
            <Row key={job.id} job={job} onDone={() => setOpen(false)} />
          ))}
          <li>
            <a href="/jobs" onClick={() => setOpen(false)}>
              {w("button.allJobs")}
            </a>
          </li>
        </ul>
      )}
    </span>
  );
}

const STATES: Record<string, Word> = {
  done: "label.jobDone",
  failed: "label.jobFailed",
  cancelled: "label.jobCancelled",
  waiting: "label.jobWaiting",
};

function Row({ job, onDone }: { job: Job; onDone: () => void }) {
  return (
    <li class="job">
      <div class="row">
        <strong class="cut grow">{job.name ?? job.analysis}</strong>
        <span class="dim">{STATES[job.state] ? w(entryOf(STATES, job.state)) : stageOf(job)}</span>
        {running(job) && (
          <button
            type="button"
            class="button quiet icon dense"
            aria-label={w("button.cancel")}
            title={w("button.cancel")}
            onClick={() => void cancelJob(job)}
          >
            <Icon name="close" />
          </button>
        )}
      </div>
      {running(job) && <progress value={job.share} aria-label={stageOf(job)} />}
      {job.problem && (
        <p>
          {job.problem.detail ?? job.problem.title} {job.problem.remedy}
        </p>
      )}
      {job.result && (
        <a href={placeOf(job.analysis, job.result)} onClick={onDone}>
          {w("button.openResult")}
        </a>
      )}
    </li>
  );
}

/** Whether the open page is one that shows the ends of its own jobs. */
const waitedFor = (): boolean => Boolean(rowOf(route.peek().page)?.jobs);
