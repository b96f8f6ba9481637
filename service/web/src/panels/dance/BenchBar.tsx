/** What is danced to: a tempo by number, taps or music, how long, from which seed; dry run and making of it. */
import { itemAt } from "../../lists";
import { useState } from "preact/hooks";
import { address, ask, fetched, get } from "../../api/client";
import { partOf, resultOf } from "../../api/results";
import { cancelJob, jobs, runAnalysis } from "../../state/session/jobs";
import { note, refuse } from "../../state/session/notes";
import { go, param, route, setParams } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { NumberField } from "../../ui/forms/NumberField";
import { Trouble } from "../../ui/Trouble";
import { number, w } from "../../words";
import { USUAL_BARS, USUAL_BPM, type Bench } from "./bench";
import { offsetNow, setOffset, tap, taps } from "./keys";
import { DancersFields } from "./DancersFields";
import { readMusic, withChoice } from "./music";
import { d } from "./words";

const MOST_BARS = 512;
const write = (name: string) => (value: number | null) => setParams({ [name]: value === null ? null : String(value) });

export function BenchBar({ bench, onOthers }: { bench: Bench; onOthers?: () => void }) {
  const [error, setError] = useState<unknown>(null);
  const [reading, setReading] = useState("");
  const music = bench.music.value;
  const job = jobs.value.find(
    (one) => one.id === bench.job.value?.id && (one.state === "waiting" || one.state === "running"),
  );
  const run = async (dry: boolean) => {
    setError(null);
    try {
      const id = await runAnalysis(
        "dance",
        {
          inputs: { documents: bench.timed },
          parameters: { ...bench.wish(), dry_run: dry },
          name: dry ? undefined : "dance",
        },
        (started) => (bench.job.value = started),
      );
      const result = await resultOf(id);
      if (dry) {
        bench.dry.value = result;
        setParams({ tab: "stage" });
        return;
      }
      bench.dry.value = null;
      await keepMusic(bench, partOf(result, "clip").document!);
      go(`/dance/${id}?${withoutSelection()}`);
      note(d("label.made", { name: result.name }), {
        detail: music ? d("help.musicKept") : undefined,
        action: {
          text: d("button.undoMade"),
          run: () => void takeBack(id, partOf(result, "clip").document!, result.name, bench),
        },
      });
    } catch (refused) {
      if ((refused as Error).name !== "AbortError") setError(refused);
    } finally {
      bench.job.value = null;
    }
  };
  const open = async (file: File, bpm?: number) => {
    setError(null);
    setReading(file.name);
    try {
      bench.music.value = await readMusic(file, bpm);
    } catch (refused) {
      setError(refused);
    } finally {
      setReading("");
    }
  };
  return (
    <>
      <header class="bench-bar row wrap">
        <span class="row">
          <strong>{d("label.bench", { n: bench.documents.length })}</strong>
          {onOthers && (
            <button type="button" class="button quiet dense" onClick={onOthers}>
              {d("label.others")}
            </button>
          )}
        </span>
        {music ? (
          <span class="row bench-music">
            <Icon name="beat" />
            <span class="cut">{music.file.name}</span>
            <span class="dim">{music.even ? number(music.bpm, 1) : d("label.uneven")}</span>
            {music.rivals.length > 1 && (
              <label class="row" title={d("help.rivalsHelp")}>
                {music.clear ? d("label.tempo") : d("label.ambiguous")}
                <select
                  class="field dense"
                  value={0}
                  onChange={(event) =>
                    void open(music.file, itemAt(music.rivals, Number(event.currentTarget.value)).bpm)
                  }
                >
                  {music.rivals.map((one, at) => (
                    <option key={at} value={at}>
                      {d("label.rival", { bpm: number(one.bpm, 1), strength: number(one.strength, 2) })}
                    </option>
                  ))}
                </select>
              </label>
            )}
            <label class="row">
              {d("label.perBar")}
              <select
                class="field dense"
                value={music.beatsPerBar}
                onChange={(event) =>
                  (bench.music.value = withChoice(music, { beatsPerBar: Number(event.currentTarget.value) }))
                }
              >
                {[2, 3, 4].map((one) => (
                  <option key={one} value={one}>
                    {one}
                  </option>
                ))}
              </select>
            </label>
            <label class="row">
              {d("label.downbeat")}
              <select
                class="field dense"
                value={music.downbeat}
                onChange={(event) =>
                  (bench.music.value = withChoice(music, { downbeat: Number(event.currentTarget.value) }))
                }
              >
                {music.beats.slice(0, 16).map((_, at) => (
                  <option key={at} value={at + 1}>
                    {at + 1}
                  </option>
                ))}
              </select>
            </label>
            <label class="row">
              {d("label.factor")}
              <select
                class="field dense"
                value={music.factor}
                onChange={(event) =>
                  (bench.music.value = withChoice(music, { factor: event.currentTarget.value as "1" }))
                }
              >
                {["1/2", "1", "2"].map((one) => (
                  <option key={one} value={one}>
                    {one}
                  </option>
                ))}
              </select>
            </label>
            <label class="row">
              {d("label.offset")}
              <NumberField step={0.01} value={offsetNow()} onChange={(value) => setOffset(value ?? 0)} /> s
            </label>
            <button
              type="button"
              class="button quiet icon dense"
              aria-label={d("button.musicGone", { name: music.file.name })}
              onClick={() => {
                if (music.address) URL.revokeObjectURL(music.address);
                bench.music.value = null;
                setOffset(0);
              }}
            >
              <Icon name="close" />
            </button>
          </span>
        ) : (
          <span class="row">
            <label class="row">
              {d("label.tempo")}
              <NumberField least={40} most={240} value={Number(param("bpm")) || USUAL_BPM} onChange={write("bpm")} />
            </label>
            <span class="dim">{d("label.bpm")}</span>
            <button
              type="button"
              class="button"
              title={d("help.tapHelp")}
              onPointerDown={(event) => {
                if (event.button === 0) tap(event.timeStamp);
              }}
              onClick={(event) => {
                if (event.detail === 0) tap(event.timeStamp);
              }}
            >
              {d("button.tap")}
              {taps.value.length > 1 && <span class="dim">{d("label.taps", { n: taps.value.length })}</span>}
            </button>
            <label class="button" title={d("help.musicHelp")}>
              {d("label.music")}…
              <input
                class="unseen"
                type="file"
                accept=".wav,.flac,.mp3,audio/*"
                aria-label={d("label.music")}
                onChange={(event) => {
                  const file = event.currentTarget.files?.[0];
                  if (file) void open(file);
                }}
              />
            </label>
          </span>
        )}
        <label class="row">
          {d("label.bars")}
          <NumberField
            least={1}
            most={MOST_BARS}
            step={1}
            value={Number(param("bars")) || USUAL_BARS}
            onChange={write("bars")}
          />
        </label>
        <PathFields />
        <DancersFields />
        <span class="grow" />
        {job ? (
          <span class="row grow bench-job" role="status">
            <progress class="grow" value={job.share} aria-label={job.stage ?? ""} />
            <span class="dim">{d("label.making", { stage: job.stage ?? "" })}</span>
            <button type="button" class="button" onClick={() => void cancelJob(job)}>
              {w("button.cancel")}
            </button>
          </span>
        ) : (
          <span class="row">
            <button type="button" class="button" disabled={bench.job.value !== null} onClick={() => void run(true)}>
              {d("button.dryRun")}
            </button>
            <button
              type="button"
              class="button primary"
              disabled={bench.job.value !== null}
              onClick={() => void run(false)}
            >
              {d("button.make")}
            </button>
          </span>
        )}
      </header>
      {reading && (
        <p class="row bench-reading" role="status">
          <span class="dim">{d("label.readingMusic", { name: reading })}</span>
          <span class="busy grow" />
        </p>
      )}
      <Trouble error={error} />
    </>
  );
}

function PathFields() {
  return (
    <>
      <label class="row" title={d("help.seedHelp")}>
        {d("label.seed")}
        <NumberField
          least={0}
          step={1}
          value={Number(param("seed")) || 0}
          onChange={(value) => write("seed")(value || null)}
        />
      </label>
      <label class="row" title={d("help.stageHelp")}>
        {d("label.stageRadius")}
        <NumberField least={0.5} step={0.5} value={Number(param("stage")) || null} onChange={write("stage")} />
      </label>
    </>
  );
}

/** The address without the clips that were chosen: a result says itself what it was made of. */
function withoutSelection(): string {
  const params = new URLSearchParams(route.peek().params);
  for (const name of ["doc", "project", "motion_name", "property", "xpath"]) params.delete(name);
  params.set("tab", "stage");
  return params.toString();
}

/** The music stays with the dance, so that it plays on the clip's page too. */
async function keepMusic(bench: Bench, document: string): Promise<void> {
  const music = bench.music.peek();
  if (!music) return;
  const form = new FormData();
  form.append("file", music.file, music.file.name);
  form.append("offset", String(offsetNow()));
  try {
    await fetched(address("/documents/{id}/media", { id: document }), { method: "PUT", body: form });
  } catch (error) {
    refuse(error);
  }
}

async function takeBack(result: string, document: string, name: string, bench: Bench): Promise<void> {
  try {
    const { revision } = await get("/documents/{id}", { path: { id: document } });
    await ask("delete", "/documents/{id}", { path: { id: document }, match: revision });
    await ask("delete", "/results/{id}", { path: { id: result } });
    bench.shown.value = null;
    const params = new URLSearchParams(route.peek().params);
    for (const id of bench.documents) params.append("doc", id);
    go(`/dance?${params}`);
    note(d("label.taken", { name }));
  } catch (error) {
    refuse(error);
  }
}
