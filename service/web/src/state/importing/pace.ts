/** How fast an import is, and how long what is left of it takes: the arithmetic of mcml/pace.py. */
import { itemAt } from "../../lists";
const LOOKED_BACK = 15_000; // ms; files that are stored already go by much faster than others
const FEWEST = 500; // ms, before which no rate is told

export interface Told {
  /** Files a second. */
  rate: number;
  /** Seconds until all are done. */
  left: number;
}

export class Pace {
  private readonly told: { at: number; done: number }[] = [];

  constructor(private readonly clock: () => number = () => performance.now()) {}

  /** So many files are done now. */
  tell(done: number): void {
    const now = this.clock();
    this.told.push({ at: now, done });
    // One that lies further back stays, so that there is a rate while a long file is read.
    while (this.told.length > 2 && itemAt(this.told, 1).at <= now - LOOKED_BACK) this.told.shift();
  }

  /** null before it is known, and where nothing is left. */
  now(of: number): Told | null {
    const [first, last] = [this.told[0], this.told.at(-1)];
    if (!first || !last || last.done >= of) return null;
    const seconds = (this.clock() - first.at) / 1000;
    if (seconds * 1000 < FEWEST || last.done <= first.done) return null;
    const rate = (last.done - first.done) / seconds;
    return { rate, left: (of - last.done) / rate };
  }
}

/** A time that is left: whole seconds, 2:04 from a minute on, 1:02:04 from an hour on. */
export function timeLeft(seconds: number): string {
  const whole = Math.max(1, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  const two = (value: number) => String(value).padStart(2, "0");
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}
