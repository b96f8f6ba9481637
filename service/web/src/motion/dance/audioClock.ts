/** The clock of what is heard, told at any moment: readings repeat and jitter, so their distance to the page's clock is smoothed. */

export interface Reading {
  contextTime?: number;
  performanceTime?: number;
}

const SHARE = 0.05; // of what a new reading says differently that is taken over; more of the first ones, which are few
const JUMP = 0.03; // seconds: more than that is no jitter, and taken over whole

export class AudioClock {
  /** Seconds that the sound is ahead of the page's clock; null before anything was heard. */
  private ahead: number | null = null;
  private last = -1;
  private readings = 0;

  /** Seconds of the context that are heard at `now` (ms, as of an animation frame), given its newest reading. */
  at(now: number, { contextTime = 0, performanceTime = 0 }: Reading): number | null {
    if (performanceTime > 0 && contextTime > 0 && performanceTime !== this.last) {
      this.last = performanceTime;
      const ahead = contextTime - performanceTime / 1000;
      if (this.ahead === null || Math.abs(ahead - this.ahead) > JUMP) [this.ahead, this.readings] = [ahead, 1];
      else this.ahead += Math.max(SHARE, 1 / ++this.readings) * (ahead - this.ahead);
    }
    return this.ahead === null ? null : now / 1000 + this.ahead;
  }

  reset(): void {
    this.ahead = null;
    this.last = -1;
  }
}
