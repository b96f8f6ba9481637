/** A body that is led now: its clock, its goal, what is drawn of it, and what it has played. */
import { signal } from "@preact/signals";
import { itemAt, numberAt } from "../../lists";
import { Path, steered } from "../../motion/matching/goals";
import type { Point } from "../../motion/matching/library";
import { decay, posed, segmentsOf, velocityOf } from "../../motion/matching/playing";
import { SEARCH_EVERY, Walker, type Wish } from "../../motion/matching/walker";
import type { Loaded } from "./loading";

const STEERING = Math.PI / 18; // by which a cut may turn the body
const FADE = 9; // rows over which a difference decays: 0.3 s
const MOST_RUNS = 1000; // that one composition takes
const ARRIVED = 0.1; // metres before the end of a path
const [NEAR, STANDS] = [0.75, 0.1]; // metres, metres a second: a body that stands so near has arrived
const LONGEST_STEP = 0.1; // seconds of one tick: a page that slept does not run to catch up
const TRAIL = 1800; // places of the body on the map

export type State = "still" | "running" | "arrived" | "full";

export class Session {
  readonly state = signal<State>("still");
  /** Moves with every picture. */
  readonly drawn = signal(0);
  readonly speed = signal(1.2);
  readonly path = signal<Path | null>(null);
  /** Metres to the path; null: none is followed. */
  readonly distance = signal<number | null>(null);
  positions: Float32Array;
  trail: Point[] = [];
  walker: Walker;
  /** The direction that keys or a pad give on the ground, at most of length 1. */
  lead: () => Point = () => [0, 0];
  private way = 0;
  private rows = 0;
  private part = 0;
  private since = FADE;
  private offsets: Float32Array;
  private speeds: Float32Array;
  private last = 0;
  private timer = 0;

  constructor(readonly loaded: Loaded) {
    this.speed.value = Math.max(0.1, Math.round(loaded.facts.speed * 20) / 20);
    this.walker = this.begin([0, 0], 0);
    this.positions = this.pose();
    this.offsets = new Float32Array(this.positions.length);
    this.speeds = new Float32Array(this.positions.length);
  }

  get seconds(): number {
    return this.rows / this.loaded.facts.rate;
  }

  get cuts(): number {
    return this.walker.ended.length;
  }

  get segments() {
    return segmentsOf(this.loaded.library, this.walker.runs);
  }

  /** From the beginning, without a path or along one. */
  restart(path: Path | null = null): void {
    this.pause();
    this.path.value = path;
    const [place, facing] = path ? path.at(0) : [[0, 0] as Point, 0];
    this.walker = this.begin(place, facing);
    this.distance.value = path ? 0 : null;
    this.draw();
  }

  run(): void {
    if (this.state.peek() !== "still") return;
    this.state.value = "running";
    this.last = performance.now();
    this.timer = requestAnimationFrame(this.tick);
  }

  pause(): void {
    cancelAnimationFrame(this.timer);
    if (this.state.peek() === "running") this.state.value = "still";
  }

  private begin(place: Point, facing: number): Walker {
    const walker = new Walker(this.loaded.library, place, facing, STEERING);
    this.way = this.rows = this.part = 0;
    this.since = FADE;
    this.trail = [place];
    this.state.value = "still";
    walker.begin(this.wish(walker));
    return walker;
  }

  private wish(walker: Walker): Wish {
    const path = this.path.peek();
    if (path) return path.wish(this.way, this.speed.peek());
    const [x, y] = this.lead();
    const velocity = walker.row < 0 ? ([0, 0] as const) : velocityOf(this.loaded.library, walker.run, walker.row);
    return steered(walker.place, walker.facing, velocity, [x * this.speed.peek(), y * this.speed.peek()]);
  }

  private readonly tick = (now: number): void => {
    if (this.state.peek() !== "running") return;
    this.part += Math.min(LONGEST_STEP, (now - this.last) / 1000) * this.loaded.facts.rate;
    this.last = now;
    while (this.part >= 1 && this.state.peek() === "running") {
      this.part--;
      this.step();
    }
    this.draw();
    if (this.state.peek() === "running") this.timer = requestAnimationFrame(this.tick);
  };

  /** One row on. Tests call it without a clock. */
  step(): void {
    const { walker } = this;
    const path = this.path.peek();
    if (path) {
      const [way, distance] = path.progress(walker.place, this.way);
      this.way = way;
      this.distance.value = distance;
      const left = path.length - way;
      if (left < ARRIVED || (left < NEAR && walker.speed < STANDS)) {
        this.state.value = "arrived";
        return;
      }
    }
    if (walker.ended.length >= MOST_RUNS - 1) {
      this.state.value = "full";
      return;
    }
    if (this.rows % SEARCH_EVERY === 0 || walker.atEnd) this.choose();
    walker.advance();
    this.rows++;
    this.since++;
    this.trail.push(walker.place);
    if (this.trail.length > TRAIL) this.trail.shift();
  }

  private choose(): void {
    const { walker } = this;
    const shown = [this.at(walker.row - 1, -1), this.at(walker.row, 0)] as const;
    if (!walker.choose(this.wish(walker))) return;
    const next = [this.plain(walker.row - 1), this.plain(walker.row)] as const;
    const [before, now] = shown;
    this.offsets = now.map((value, at) => value - numberAt(next[1], at));
    this.speeds = this.offsets.map((value, at) => value - (numberAt(before, at) - numberAt(next[0], at)));
    this.since = 0;
  }

  /** Points at a row of the present run. */
  private plain(row: number): Float32Array {
    const { library, clips } = this.loaded;
    const clip = itemAt(library.facts.clips, library.clipOf(this.walker.row));
    return posed(library, clips, this.walker.run, Math.max(clip.first, Math.min(clip.last, row)));
  }

  /** The same as it is drawn, `ahead` rows from now, with the difference that still decays. */
  private at(row: number, ahead: number): Float32Array {
    const values = this.plain(row);
    const since = this.since + ahead;
    if (since >= FADE || since < 0) return values;
    return values.map((value, at) => {
      const off = numberAt(this.offsets, at);
      return off === off ? value + decay(off, numberAt(this.speeds, at), since, FADE) : value;
    });
  }

  private pose(): Float32Array {
    return this.at(this.walker.row + this.part, this.part);
  }

  private draw(): void {
    this.positions = this.pose();
    this.drawn.value++;
  }
}
