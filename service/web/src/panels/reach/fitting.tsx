/** A fit that is under way: started, watched, cancelled; what refuses it, with the clips that can be left out. */
import { useState } from "preact/hooks";
import { ApiError } from "../../api/client";
import { cancelJob, jobs, runAnalysis, type Job } from "../../state/session/jobs";
import { go, route } from "../../state/session/route";
import { stageOf } from "../../ui/analyses/titles";
import { Trouble } from "../../ui/Trouble";
import { number, w } from "../../words";
import { b } from "./words";

export interface Fitting {
  job: Job | undefined;
  busy: boolean;
  error: unknown;
  start: (body: object, keep?: boolean) => Promise<void>;
}

/** Fits a model and opens it. keep: with the address's sliders and tab. */
export function useFit(): Fitting {
  const [error, setError] = useState<unknown>(null);
  const [running, setRunning] = useState<string | null>(null);
  const [busy, setBusy] = useState(false);
  const start = async (body: object, keep = false) => {
    setError(null);
    setBusy(true);
    try {
      const result = await runAnalysis("reach", body, (job) => setRunning(job.id));
      const params = keep ? route.peek().params.toString() : "";
      go(`/reach/${result}${params ? `?${params}` : ""}`);
    } catch (refused) {
      if ((refused as Error).name !== "AbortError") setError(refused);
    } finally {
      setRunning(null);
      setBusy(false);
    }
  };
  return { job: jobs.value.find((one) => one.id === running), busy, error, start };
}

export function FitProgress({ job }: { job: Job }) {
  return (
    <div class="row fit-progress" role="status">
      <progress class="grow" value={job.share} aria-label={b("label.fitting")} />
      <span class="dim">
        {stageOf({ stage: job.stage ?? "waiting" })} {number((job.share ?? 0) * 100, 0)} %
      </span>
      <button type="button" class="button" onClick={() => void cancelJob(job)}>
        {w("button.cancel")}
      </button>
    </div>
  );
}

/** What was refused. onExclude: leave these clips out and try again. */
export function FitTrouble({ error, onExclude }: { error: unknown; onExclude: (documents: string[]) => void }) {
  const found = error instanceof ApiError ? (error.problem.details?.leave_out as string[] | undefined) : undefined;
  return (
    <>
      <Trouble error={error} />
      {found && found.length > 0 && (
        <p>
          <button type="button" class="button" onClick={() => onExclude(found)}>
            {b("button.excludeThese", { n: found.length })}
          </button>
        </p>
      )}
    </>
  );
}
