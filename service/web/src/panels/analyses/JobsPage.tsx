/** The log of jobs, the newest first: state, duration and reason of each, also of other people; cancelled and run again here. */
import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { get, type Schemas } from "../../api/client";
import { param, setParams } from "../../state/session/route";
import { cancelJob, isOver, jobs, placeOf, startAnalysis, type Job } from "../../state/session/jobs";
import { refuse } from "../../state/session/notes";
import { subject } from "../../state/session/shell";
import { analysisTitle, stageOf } from "../../ui/analyses/titles";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { duration, w, when } from "../../words";
import { a } from "./words";
import "../../styles/analyses.css";

type State = Job["state"];
type Info = Schemas["AnalysisInfo"];

const STATES: readonly State[] = ["waiting", "running", "done", "failed", "cancelled"];
const NONE: Job[] = [];
const PAGE = 50;
const LOOK_EVERY = 2000; // ms, while a job runs that this window does not follow

export function JobsPage() {
  const [most, setMost] = useState(PAGE);
  const state = STATES.find((one) => one === param("state"));
  const project = param("project") || undefined;
  useEffect(() => {
    subject.value = null;
  }, []);
  const analyses = useAsync((signal) => get("/analyses", { signal }), []);
  const { value, before, error, again } = useAsync(
    (signal) => get("/jobs", { query: { state, project, limit: most }, signal }),
    [state, project, most],
    [jobs.value.map((job) => job.id + job.state).join()],
  );
  const shown = (value ?? before)?.items ?? NONE;
  useEffect(() => {
    if (shown.every(isOver)) return;
    const timer = window.setTimeout(again, LOOK_EVERY);
    return () => window.clearTimeout(timer);
  }, [shown, again]);
  return (
    <div class="analyses jobs-page">
      <header class="row">
        <h1 class="grow">{w("label.jobs")}</h1>
        <Filters state={state} project={project} />
      </header>
      <Trouble error={error} retry={again} />
      {shown.length > 0 && <JobTable shown={shown} analyses={analyses.value?.items ?? []} />}
      {value && <Rest page={value} filtered={Boolean(state ?? project)} onMore={() => setMost(most + PAGE)} />}
    </div>
  );
}

function Filters({ state, project }: { state: State | undefined; project: string | undefined }) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  return (
    <>
      <Filter name="state" label={a("label.state")} all={a("label.allStates")} value={state}>
        {STATES.map((one) => (
          <option key={one} value={one}>
            {a(`label.${one}`)}
          </option>
        ))}
      </Filter>
      <Filter name="project" label={a("label.project")} all={a("label.allProjects")} value={project}>
        {(projects.value?.items ?? []).map((one) => (
          <option key={one}>{one}</option>
        ))}
      </Filter>
    </>
  );
}

interface FilterProps {
  /** The parameter of the address. */
  name: string;
  label: string;
  all: string;
  value: string | undefined;
  children: ComponentChildren;
}

function Filter({ name, label, all, value, children }: FilterProps) {
  return (
    <select
      class="field"
      aria-label={label}
      value={value ?? ""}
      onChange={(event) => setParams({ [name]: event.currentTarget.value || null })}
    >
      <option value="">{all}</option>
      {children}
    </select>
  );
}

/** Below the table: why it is empty, or the way to older jobs. */
function Rest({ page, filtered, onMore }: { page: Schemas["JobPage"]; filtered: boolean; onMore: () => void }) {
  if (page.next_cursor)
    return (
      <button type="button" class="button" onClick={onMore}>
        {a("button.moreJobs")}
      </button>
    );
  if (page.items.length) return null;
  return (
    <>
      <p class="dim">{a(filtered ? "help.noSuchJobs" : "help.noJobs")}</p>
      <p>
        <a href="/analyses">{w("button.goAnalyses")}</a>
      </p>
    </>
  );
}

function JobTable({ shown, analyses }: { shown: readonly Job[]; analyses: readonly Info[] }) {
  const several = new Set(shown.map((job) => job.owner)).size > 1;
  return (
    <div class="scroll-x">
      <table class="jobs-table">
        <thead>
          <tr>
            <th scope="col">{a("label.job")}</th>
            <th scope="col">{a("label.state")}</th>
            <th scope="col">{a("label.clipsWord")}</th>
            <th scope="col">{a("label.created")}</th>
            <th scope="col">{a("label.duration")}</th>
            {several && <th scope="col">{a("label.person")}</th>}
            <th scope="col">
              <span class="unseen">{a("label.operations")}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {shown.map((job) => (
            <JobRow
              key={job.id}
              job={job}
              info={analyses.find((one) => one.name === job.analysis)}
              person={several ? job.owner : undefined}
            />
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** Seconds that a job took, or takes until now. */
function secondsOf(job: Job): number | null {
  if (!job.started) return null;
  const end = job.ended ? new Date(job.ended).getTime() : Date.now();
  return Math.max(0, end - new Date(job.started).getTime()) / 1000;
}

function JobRow({ job, info, person }: { job: Job; info: Info | undefined; person: string | undefined }) {
  const title = info ? analysisTitle(info) : job.analysis;
  return (
    <tr data-state={job.state}>
      <th scope="row">
        {job.result ? <a href={placeOf(job.analysis, job.result)}>{job.name}</a> : job.name}
        {job.name !== title && <span class="dim block">{title}</span>}
      </th>
      <td>
        {a(`label.${job.state}`)}
        {job.state === "running" && (
          <>
            <progress value={job.share} aria-label={stageOf(job)} />
            <span class="dim block">{stageOf(job)}</span>
          </>
        )}
        {job.attempt > 1 && <span class="dim block">{a("label.attempt", { n: job.attempt })}</span>}
        {job.problem && (
          <p class="reason">
            {job.problem.detail} {job.problem.remedy}
          </p>
        )}
      </td>
      <td class="n">{job.inputs.length}</td>
      <td class="dim">
        <time dateTime={job.created} title={new Date(job.created).toLocaleString()}>
          {when(job.created)}
        </time>
      </td>
      <td class="n">{duration(secondsOf(job))}</td>
      {person !== undefined && <td>{person}</td>}
      <td>
        {isOver(job) ? (
          <button type="button" class="button dense" onClick={() => void runAgain(job)}>
            {a("button.runAgain")}
          </button>
        ) : (
          <button type="button" class="button dense" onClick={() => void cancelJob(job)}>
            {w("button.cancel")}
          </button>
        )}
      </td>
    </tr>
  );
}

/** The same analysis of the same clips, as they are now. */
async function runAgain({ analysis, name, inputs, parameters }: Job): Promise<void> {
  const documents = inputs.map((one) => one.document);
  try {
    await startAnalysis(analysis, { inputs: { documents }, parameters, name });
  } catch (error) {
    refuse(error);
  }
}
