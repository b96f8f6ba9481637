/** The motion that follows the sliders: one question under way, the latest values next, late answers dropped. */
import { computed, signal } from "@preact/signals";
import { ApiError, type Schemas } from "../../api/client";
import { makeMotion } from "../../api/results";
import { samePhase, type Moments } from "../../motion/timeline/phases";
import { wholeOf, type Preview } from "../../motion/loading/preview";
import { Player } from "../../state/clip/player";
import { noteParams, param } from "../../state/session/route";
import { middleOf, paramOf, type Model, type Values } from "./model";

export type Answer = Schemas["ReachMotion"];
export interface Shown {
  answer: Answer;
  preview: Preview;
  moments: Moments;
}

/** X, Y and Z in metres, in the world of the made motion. */
export type Place = [number, number, number];

export interface Wish {
  attributes: Values;
  target?: Place;
}

export class Blending {
  readonly values;
  /** Where the hand is to be at the end of the reach; null: where the blend has it. */
  readonly target;
  readonly shown = signal<Shown | null>(null);
  /** Whether the target is being set: arrows in the viewer drag it. */
  readonly aiming = signal(false);
  /** The target, else where the hand of the made motion is; null: the model knows no place of the hand. */
  readonly place = computed(() => {
    const place = this.shown.value?.answer.hand_place;
    return this.target.value ?? (place ? (place.map((one) => Number(one.toFixed(3))) as Place) : null);
  });
  /** Where the hand comes nearest to a target that is out of reach, and how many metres are missing. */
  readonly missed = computed(() => missedBy(this.error.value));
  readonly error = signal<unknown>(null);
  /** Milliseconds from the question to its answer. */
  readonly took = signal(0);
  readonly player = new Player(1, 30);
  private wanted: { wish: Wish; moved: number } | null = null;
  private busy = false;
  /** When the slider was moved for the motion that waits to be drawn. */
  private undrawn: number | null = null;
  private readonly stop = new AbortController();

  constructor(readonly model: Model) {
    this.values = signal<Values>(valuesNow(model));
    this.target = signal<Place | null>(targetNow());
    this.aiming.value = this.target.value !== null;
    this.want();
  }

  /** Move sliders. */
  set(changes: Values): void {
    this.values.value = { ...this.values.peek(), ...changes };
    noteParams(Object.fromEntries(Object.entries(changes).map(([name, value]) => [paramOf(name), String(value)])));
    this.want();
  }

  /** Set or remove the place of the hand. */
  aim(target: Place | null): void {
    this.target.value = target;
    noteParams({ target: target && target.join(",") });
    this.want();
  }

  /** The request for the motion that is shown. */
  wish(): Wish {
    const target = this.target.peek();
    return { attributes: this.values.peek(), ...(target && { target }) };
  }

  /** As the address says, after going back and forth in it. */
  read(): void {
    const now = valuesNow(this.model);
    const target = targetNow();
    if (JSON.stringify([now, target]) === JSON.stringify([this.values.peek(), this.target.peek()])) return;
    this.values.value = now;
    this.target.value = target;
    this.want();
  }

  close(): void {
    this.stop.abort();
    this.player.pause();
  }

  private want(): void {
    this.wanted = { wish: this.wish(), moved: performance.now() };
    if (!this.busy) void this.follow();
  }

  private async follow(): Promise<void> {
    this.busy = true;
    while (this.wanted && !this.stop.signal.aborted) {
      const { wish, moved } = this.wanted;
      this.wanted = null;
      const asked = performance.now();
      try {
        const made = await makeMotion<Answer>(this.model.id, "synthesize", wish, {}, this.stop.signal);
        this.show(made.value, wholeOf(made.motion, made.positions), moved);
        this.took.value = performance.now() - asked;
        this.error.value = null;
      } catch (error) {
        if (!this.stop.signal.aborted) this.error.value = error;
      }
    }
    this.busy = false;
  }

  private show(answer: Answer, preview: Preview, moved: number): void {
    const moments: Moments = [0, answer.t1.frames, answer.t2.frames, answer.end.frames];
    const before = this.shown.peek();
    const at = before ? samePhase(this.player.at, before.moments, moments) : 0;
    this.shown.value = { answer, preview, moments };
    this.player.become(preview.frames, preview.perSecond, at);
    if (!before && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.player.play(1);
    this.undrawn = moved;
  }

  /** The stage has drawn: how long it took from the move of a slider is measured. */
  drawn(): void {
    if (this.undrawn === null) return;
    performance.measure("new-motion", { start: this.undrawn });
    this.undrawn = null;
  }
}

function missedBy(error: unknown): { distance: number; nearest: Place } | null {
  if (!(error instanceof ApiError) || error.problem.code !== "out-of-reach") return null;
  const { distance, nearest } = error.problem.details ?? {};
  return typeof distance === "number" && Array.isArray(nearest) ? { distance, nearest: nearest as Place } : null;
}

function targetNow(): Place | null {
  const place = param("target").split(",").map(Number);
  return place.length === 3 && place.every(Number.isFinite) ? (place as Place) : null;
}

function valuesNow(model: Model): Values {
  const middle = middleOf(model);
  for (const { name } of model.attributes) {
    const said = param(paramOf(name));
    if (said !== "" && Number.isFinite(Number(said))) middle[name] = Number(said);
  }
  return middle;
}
