/** One clock: the time of what is looked at, in frames from 0. Runs only while something plays. */
import { batch, signal, type Signal } from "@preact/signals";

export class Player {
  /** The frame that is shown, from 0. */
  readonly frame = signal(0);
  readonly playing = signal(false);
  /** Times natural speed; negative plays backwards. */
  readonly speed = signal(1);
  /** The stretch that repeats, frames from 0, both included; null: the whole clip. */
  readonly loop = signal<[number, number] | null>(null);
  /** The clock that leads while it plays, such as a sound's: frames from 0 at `now` (ms of the animation frame); null
   * where it does not. */
  lead: ((now: number) => number | null) | null = null;
  private exact = 0;
  private last = 0;
  private timer = 0;

  /** What is played: how many frames, and how fast. */
  private readonly length: Signal<{ frames: number; perSecond: number }>;

  constructor(frames: number, perSecond: number) {
    this.length = signal({ frames, perSecond });
  }

  get frames(): number {
    return this.length.value.frames;
  }

  get perSecond(): number {
    return this.length.value.perSecond;
  }

  /** Where it is between two frames. */
  get at(): number {
    return this.exact;
  }

  /** Go on at a frame of another motion, playing or not as before. */
  become(frames: number, perSecond: number, at: number): void {
    batch(() => {
      const now = this.length.peek();
      if (now.frames !== frames || now.perSecond !== perSecond) this.length.value = { frames, perSecond };
      this.seek(at);
    });
  }

  seek(frame: number): void {
    this.exact = Math.max(0, Math.min(this.length.peek().frames - 1, frame));
    this.frame.value = Math.floor(this.exact + 1e-6);
  }

  step(frames: number): void {
    this.pause();
    this.seek(this.frame.peek() + frames);
  }

  get range(): [number, number] {
    return this.loop.peek() ?? [0, Math.max(0, this.length.peek().frames - 1)];
  }

  play(speed = this.speed.peek()): void {
    if (this.frames < 2) return;
    this.speed.value = speed;
    const [first, last] = this.range;
    if (speed > 0 && this.frame.peek() >= last) this.seek(first);
    if (speed < 0 && this.frame.peek() <= first) this.seek(last);
    if (this.playing.peek()) return;
    this.playing.value = true;
    this.last = performance.now();
    this.timer = requestAnimationFrame(this.tick);
  }

  pause(): void {
    this.playing.value = false;
    cancelAnimationFrame(this.timer);
  }

  toggle(): void {
    if (this.playing.peek()) this.pause();
    else this.play(Math.abs(this.speed.peek()) || 1);
  }

  /** J, K, L of editing rooms: the same key again is 2, 4, 8 times as fast. */
  shuttle(direction: 1 | -1): void {
    const now = this.playing.peek() ? this.speed.peek() : 0;
    const faster = Math.sign(now) === direction ? Math.min(8, Math.abs(now) * 2) : 1;
    this.play(direction * faster);
  }

  private readonly tick = (now: number): void => {
    if (!this.playing.peek()) return;
    const seconds = Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    const [first, last] = this.range;
    const span = last - first + 1;
    let next = this.lead?.(now) ?? this.exact + seconds * this.perSecond * this.speed.peek();
    // A loop begun outside of its range runs into it.
    if (next >= last + 1) next = first + ((next - first) % span);
    else if (next < first && this.speed.peek() < 0) next = last + 1 - ((first - next) % span) - 1e-6;
    this.exact = Math.max(0, Math.min(this.frames - 1e-6, next));
    this.frame.value = Math.floor(this.exact);
    this.timer = requestAnimationFrame(this.tick);
  };
}
