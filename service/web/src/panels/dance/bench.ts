/** A bench: some clips, what a person corrected of their beats, and what was made of them. Kept over a reload. */
import { computed, signal } from "@preact/signals";
import { ApiError, ask } from "../../api/client";
import { resultOf, type Result } from "../../api/results";
import { accepted, movedBeat, readAllowed, withBeat, withoutBeat, type Beat } from "../../motion/dance/dancing";
import { dropJob, runAnalysis, type Job } from "../../state/session/jobs";
import type { Player } from "../../state/clip/player";
import { param } from "../../state/session/route";
import { Steps } from "../../state/editing/steps";
import type { Music } from "./music";
import { readRows, type ClipRow } from "./rows";

export interface Correction {
  beats?: Beat[];
  source_bpm?: number;
  beats_from?: "detected" | "tracked";
}
export type Corrections = Readonly<Record<string, Correction>>;

/** What moves on the stage. */
export type Shown =
  | { kind: "clip"; document: string; loop?: [number, number] }
  | { kind: "step"; from: Place; to: Place }
  | { kind: "dance"; result: Result };
/** A bar: its number in the graph, and where it is. Frames from 1. */
export interface Place {
  bar: number;
  document: string;
  number: number;
  first: number;
  last: number;
}

const LOOKED_AT_ONCE = 8;
export const USUAL_BPM = 120;
export const USUAL_BARS = 16;

export class Bench {
  readonly steps: Steps<Corrections>;
  /** By document, as last analysed; beats that a person set are those of the corrections. */
  readonly found = signal<ReadonlyMap<string, ClipRow>>(new Map());
  /** Clips whose bars are being found again. */
  readonly stale = signal<ReadonlySet<string>>(new Set());
  readonly trouble = signal<unknown>(null);
  /** Clips whose frame rate nobody has stated: they are left out until it is given. */
  readonly untimed = signal<readonly { id: string; name: string }[]>([]);
  /** Clips that beats cannot be found in, with what the repository says of each: too short, too few frames a second. */
  readonly unfit = signal<readonly { id: string; why: string; remedy: string }[]>([]);
  readonly job = signal<Job | null>(null);
  readonly graph = signal<Result | null>(null);
  /** The corrections that the graph was made with. */
  readonly graphOf = signal("");
  readonly dry = signal<Result | null>(null);
  readonly music = signal<Music | null>(null);
  readonly shown = signal<Shown | null>(null);
  readonly player = signal<Player | null>(null);
  /** The clip and the beat of it that keys act on. */
  readonly clip = signal(param("clip"));
  readonly beat = signal(-1);
  /** Where the playhead stands in the clip that keys act on, seconds. */
  readonly at = signal(0);
  /** The position of the dance, from 1, whose bars are chosen; 0: none. */
  readonly position = signal(0);
  readonly rows = computed(() =>
    this.documents.map((id) => this.row(id)).filter((one): one is ClipRow => one !== undefined),
  );
  private readonly done = new Map<string, string>();
  private readonly known = new Map<string, ClipRow>();
  private busy = false;

  constructor(
    readonly documents: string[],
    before: Corrections = {},
  ) {
    this.steps = new Steps(this.kept() ?? before);
    this.steps.now.subscribe((now) => {
      try {
        sessionStorage.setItem(this.key, JSON.stringify(now));
      } catch {
        /* Private windows refuse storage. */
      }
      void this.refresh();
    });
  }

  private get key(): string {
    return `mcml.dance.${this.documents.join(",")}`;
  }

  private kept(): Corrections | null {
    try {
      return JSON.parse(sessionStorage.getItem(this.key) ?? "null") as Corrections | null;
    } catch {
      return null;
    }
  }

  row(id: string): ClipRow | undefined {
    const found = this.found.value.get(id);
    const own = this.steps.now.value[id]?.beats;
    return found && own ? { ...found, beats: own } : found;
  }

  /** Those that beats can be found in. */
  get timed(): string[] {
    const left = new Set([...this.untimed.value, ...this.unfit.value].map((one) => one.id));
    return this.documents.filter((id) => !left.has(id));
  }

  /** As the analyses take them. */
  get clips(): object[] {
    return this.timed
      .filter((id) => Object.keys(this.steps.now.peek()[id] ?? {}).length)
      .map((id) => this.parameters(id));
  }

  private parameters(id: string): object {
    const { beats, ...rest } = this.steps.now.peek()[id] ?? {};
    return { document: id, ...rest, ...(beats ? { beats: beats.map((one) => one.at) } : {}) };
  }

  /** Find beats and bars of what changed. One question is under way at most. */
  async refresh(): Promise<void> {
    const wanted = new Map(this.timed.map((id) => [id, JSON.stringify(this.parameters(id))]));
    for (const [id, text] of wanted) {
      const known = this.known.get(text);
      if (known && this.done.get(id) !== text) {
        this.done.set(id, text);
        this.found.value = new Map(this.found.peek()).set(id, known);
      }
    }
    const changed = this.timed.filter((id) => this.done.get(id) !== wanted.get(id));
    this.stale.value = new Set(changed);
    if (!changed.length || this.busy) return;
    this.busy = true;
    this.trouble.value = null;
    let job = "";
    try {
      const clips = changed
        .filter((id) => wanted.get(id) !== JSON.stringify({ document: id }))
        .map((id) => JSON.parse(wanted.get(id)!) as object);
      const result = await resultOf(
        await runAnalysis(
          "beats",
          { inputs: { documents: changed }, parameters: { clips } },
          (started) => (job = started.id),
        ),
      );
      const rows = new Map(this.found.peek());
      for (const found of readRows(result)) {
        // Where a tempo is stated no rivals are looked for: those of before can still be chosen.
        const row = found.peaks.length ? found : { ...found, peaks: rows.get(found.id)?.peaks ?? [] };
        rows.set(row.id, row);
        this.done.set(row.id, wanted.get(row.id)!);
        this.known.set(wanted.get(row.id)!, row);
      }
      this.found.value = rows;
      // What is asked while one corrects is no result to keep.
      dropJob(job);
      void ask("delete", "/results/{id}", { path: { id: result.id } }).catch(() => undefined);
    } catch (error) {
      // One clip that has no beats would leave all others without theirs.
      if (this.leaveOut(error, changed) || (await this.setApart(changed))) dropJob(job);
      else {
        if ((error as Error).name !== "AbortError") this.trouble.value = error;
        for (const id of changed) this.done.set(id, wanted.get(id)!);
      }
    } finally {
      this.busy = false;
    }
    void this.refresh();
  }

  /** Leave out the clip that a refusal names; false where it names none, or one whose beats were found before: then what
   * a person changed is refused. */
  private leaveOut(error: unknown, ids: string[]): boolean {
    const id = error instanceof ApiError ? error.problem.details?.document : undefined;
    if (!(error instanceof ApiError) || typeof id !== "string" || !ids.includes(id) || this.found.peek().has(id))
      return false;
    this.unfit.value = [...this.unfit.peek(), { id, why: error.message, remedy: error.remedy }];
    return true;
  }

  /** Leave out clips without a frame rate; false where there is none. */
  private async setApart(ids: string[]): Promise<boolean> {
    const found: { id: string; name: string }[] = [];
    try {
      for (let at = 0; at < ids.length; at += LOOKED_AT_ONCE) {
        const some = await Promise.all(
          ids.slice(at, at + LOOKED_AT_ONCE).map((id) => ask("get", "/documents/{id}", { path: { id } })),
        );
        found.push(...some.filter((one) => !one.seconds_per_frame).map(({ id, name }) => ({ id, name })));
      }
    } catch {
      return false;
    }
    this.untimed.value = [...this.untimed.peek(), ...found];
    return found.length > 0;
  }

  /** State the frame rate of a clip that was left out, Hz. */
  async giveRate(id: string, hertz: number): Promise<void> {
    const { revision } = await ask("get", "/documents/{id}", { path: { id } });
    await ask("patch", "/documents/{id}", {
      path: { id },
      match: revision,
      body: { frame_time: String(Number((1 / hertz).toPrecision(12))) } as never,
    });
    this.untimed.value = this.untimed.peek().filter((one) => one.id !== id);
    void this.refresh();
  }

  again(): void {
    this.done.clear();
    this.unfit.value = [];
    void this.refresh();
  }

  correct(id: string, change: Correction, kind = ""): void {
    const now = this.steps.now.peek();
    const next = Object.fromEntries(
      Object.entries({ ...now[id], ...change }).filter(([, value]) => value !== undefined),
    ) as Correction;
    this.steps.set({ ...now, [id]: next }, kind);
  }

  private edit(id: string, made: (beats: Beat[]) => Beat[]): void {
    const row = this.row(id);
    if (row) this.correct(id, { beats: made(row.beats) });
  }

  addBeat = (id: string, at: number): void => this.edit(id, (beats) => withBeat(beats, at));
  moveBeat = (id: string, index: number, at: number): void => {
    const end = this.row(id)?.seconds ?? 0;
    this.edit(id, (beats) => movedBeat(beats, index, Math.min(end, at)));
  };
  removeBeat = (id: string, index: number): void => {
    this.edit(id, (beats) => withoutBeat(beats, index));
    this.beat.value = -1;
  };
  accept = (id: string): void => this.edit(id, accepted);

  /** Press on a moment of a clip: keys act on it, the stage shows it. */
  go(id: string, at: number): void {
    this.clip.value = id;
    this.at.value = at;
    const shown = this.shown.peek();
    if (shown?.kind !== "clip" || shown.document !== id || shown.loop)
      this.shown.value = { kind: "clip", document: id };
    else {
      const player = this.player.peek();
      player?.seek(at * player.perSecond);
    }
  }

  /** What is to be danced, as the address has it. */
  wish(): Record<string, unknown> {
    const music = this.music.peek();
    const number = (name: string) => (param(name) === "" ? undefined : Number(param(name)));
    const allowed = [...readAllowed(param("allow"))].map(([position, bars]) => ({ position, bars }));
    const seed = number("seed");
    const count = number("dancers") ?? 1;
    const mode = param("mode") || "unison";
    const delay = mode === "canon" ? { delay: number("delay") } : {};
    return {
      clips: this.clips,
      ...(music ? { music: music.wish } : { bpm: number("bpm") ?? USUAL_BPM }),
      bars: number("bars") ?? USUAL_BARS,
      start: number("start"),
      allowed,
      threshold: number("near"),
      stage: number("stage"),
      ...(seed ? { seed } : {}),
      ...(count > 1 ? { dancers: { count, mode, spacing: number("spacing"), ...delay } } : {}),
    };
  }
}

const open = new Map<string, Bench>();

/** The bench of some clips; the one that is open, if it is theirs. */
export function benchOf(documents: string[], before?: Corrections): Bench {
  const key = documents.join(",");
  const found = open.get(key) ?? new Bench(documents, before);
  open.clear();
  open.set(key, found);
  return found;
}
