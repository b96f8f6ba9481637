/** The sound of a dance: music and clicks by Web Audio, whose clock leads the picture. The context is made on the first press. */
import { effect } from "@preact/signals";
import { AudioClock } from "../../motion/dance/audioClock";
import { clicksBetween } from "../../motion/dance/clicks";
import { kept } from "../../state/session/settings";
import type { Music } from "./music";

const FADE = 0.008; // seconds
const BEFORE = 0.04; // seconds between a press and the first sample
const AHEAD = 0.1; // clicks are scheduled so far ahead
const EVERY = 25; // ms
const TICK = 0.03; // seconds that a click sounds

export const volume = kept("dance.volume", 0.7);
export const muted = kept("dance.muted", false);
export const clicking = kept("dance.clicks", true);

let shared: AudioContext | null = null;
const contextNow = (): AudioContext => (shared ??= new AudioContext({ latencyHint: "interactive" }));

export class Sound {
  private readonly clock = new AudioClock();
  private out: GainNode | null = null;
  private source: AudioBufferSourceNode | null = null;
  private element: HTMLAudioElement | null = null;
  private timer = 0;
  /** Time of the context at which the moment `from` of the dance sounds. */
  private begun: number | null = null;
  private from = 0;
  private scheduled = 0;
  private readonly stops: (() => void)[] = [];

  /** grid: beats of the dance, seconds. offset: seconds of the music at which the dance begins. */
  constructor(
    private readonly grid: ArrayLike<number>,
    private readonly music: Music | null,
    private readonly offset: () => number,
  ) {
    this.stops.push(
      effect(() => {
        const loud = muted.value ? 0 : volume.value;
        if (this.out && shared) this.out.gain.setTargetAtTime(loud, shared.currentTime, FADE / 2);
        if (this.element) this.element.volume = loud;
      }),
    );
  }

  /** Sound from a moment of the dance on. */
  play(from: number): void {
    this.stop();
    const context = contextNow();
    void context.resume();
    this.out = context.createGain();
    this.out.connect(context.destination);
    const loud = muted.peek() ? 0 : volume.peek();
    const begun = context.currentTime + BEFORE;
    this.out.gain.setValueAtTime(0, begun);
    this.out.gain.linearRampToValueAtTime(loud, begun + FADE);
    this.begun = begun;
    this.from = from;
    this.scheduled = from;
    const place = from + this.offset();
    if (this.music?.buffer && place < this.music.buffer.duration) {
      this.source = context.createBufferSource();
      this.source.buffer = this.music.buffer;
      this.source.connect(this.out);
      this.source.start(begun + Math.max(0, -place), Math.max(0, place));
    } else if (this.music?.address && place >= 0) {
      this.element = new Audio(this.music.address);
      this.element.volume = loud;
      this.element.currentTime = place;
      void this.element.play().catch(() => undefined);
    }
    this.timer = window.setInterval(this.schedule, EVERY);
    this.schedule();
  }

  private readonly schedule = (): void => {
    const context = shared!;
    const until = this.from + (context.currentTime - this.begun!) + AHEAD;
    if (until <= this.scheduled) return;
    if (clicking.peek())
      for (const click of clicksBetween(this.grid, this.scheduled, until))
        this.click(this.begun! + click.time - this.from, click.first);
    this.scheduled = until;
  };

  private click(at: number, first: boolean): void {
    const context = shared!;
    const tone = context.createOscillator();
    const shape = context.createGain();
    tone.frequency.value = first ? 1760 : 1100;
    shape.gain.setValueAtTime(first ? 0.5 : 0.3, at);
    shape.gain.exponentialRampToValueAtTime(0.001, at + TICK);
    tone.connect(shape).connect(this.out!);
    tone.start(at);
    tone.stop(at + TICK);
  }

  /** Seconds of the dance that are heard at `now`, ms of the animation frame; null while nothing sounds. */
  time(now: number): number | null {
    if (this.begun === null) return null;
    if (this.element) return this.element.readyState < 3 ? this.from : this.element.currentTime - this.offset();
    const heard = this.clock.at(now, shared!.getOutputTimestamp());
    return heard === null ? this.from : Math.max(this.from, this.from + heard - this.begun);
  }

  /** As the context itself says it at `now`, unsmoothed: what a test compares the picture with. */
  reading(now: number): number | null {
    const { contextTime = 0, performanceTime = 0 } = shared?.getOutputTimestamp() ?? {};
    return this.begun === null || !performanceTime
      ? null
      : this.from + contextTime + (now - performanceTime) / 1000 - this.begun;
  }

  stop(): void {
    window.clearInterval(this.timer);
    if (this.out && shared) {
      const { out, source } = this;
      const now = shared.currentTime;
      out.gain.cancelScheduledValues(now);
      out.gain.setTargetAtTime(0, now, FADE / 3);
      source?.stop(now + FADE * 2);
      window.setTimeout(() => out.disconnect(), 200);
    }
    this.element?.pause();
    this.source = this.out = this.element = null;
    this.begun = null;
    this.clock.reset();
  }

  close(): void {
    this.stop();
    for (const stop of this.stops) stop();
  }
}
