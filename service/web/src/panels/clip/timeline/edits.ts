/** Edits of frames that are chosen in a dialog: their names, parameters, and requests. Pure functions. */
import type { Schemas } from "../../../api/client";

export const REPAIRS = ["fill", "despike", "low-pass", "unroll", "lock-feet"] as const;
export const CHANGES = ["loop", "in-place", "speed", "mirror"] as const;
export type Kind = (typeof REPAIRS)[number] | (typeof CHANGES)[number];
export type Edits = Schemas["FrameEdits"]["edits"];

export interface Choices {
  longest: number;
  deviations: number;
  /** null: by the motion itself. */
  hertz: number | null;
  inPlace: boolean;
  /** Of the start, the middle and the end of the range; 2: twice as fast. */
  factors: [number, number, number];
  /** Whether only the selected joints are edited. */
  selected: boolean;
}

export const START: Choices = {
  longest: 1,
  deviations: 6,
  hertz: null,
  inPlace: false,
  factors: [1, 1, 1],
  selected: false,
};

/** Frames of the edited document that are seen, every step-th; without `last`, to its end. */
export interface Seen {
  first: number;
  last?: number;
  step: number;
}

export const LEAST_FACTOR = 0.05;
export const MOST_FACTOR = 20;

/** The edit of frames first to last that the choices ask for. bones: those that are selected. */
export function editOf(kind: Kind, choices: Choices, bones: readonly string[], [first, last]: [number, number]): Edits {
  const { longest, deviations, hertz, inPlace, factors, selected } = choices;
  const only = selected ? [...bones] : [];
  const same = factors.every((one) => one === factors[0]);
  const edits = {
    fill: { do: kind, first, last, longest, bones: only },
    despike: { do: kind, first, last, deviations, bones: only },
    "low-pass": { do: kind, first, last, bones: only, ...(hertz ? { hertz } : {}) },
    unroll: { do: kind, bones: only },
    "lock-feet": { do: kind, first, last },
    loop: { do: kind, first, last, in_place: inPlace },
    "in-place": { do: kind, first, last },
    speed: { do: kind, first, last, factors: same ? [factors[0]] : factors },
    mirror: { do: kind, first, last },
  };
  return [edits[kind]] as unknown as Edits;
}

/** Whether an edit changes the motion as a whole, which is seen better than its curves. */
export const isSeen = (kind: Kind): boolean => (CHANGES as readonly string[]).includes(kind);

/** Frames of a range of so many, at other factors of its speed, linear between them. */
export function framesAt(count: number, factors: readonly number[]): number {
  const parts = Math.max(1, factors.length - 1);
  let time = 0;
  for (let at = 0; at < parts; at++) {
    const from = factors[at] ?? 1;
    const to = factors[at + 1] ?? from;
    // The mean of 1 / v, where v goes linearly from one factor to the next.
    time += Math.abs(to - from) < 1e-9 ? 1 / from : Math.log(to / from) / (to - from);
  }
  return Math.max(1, Math.round((count * time) / parts));
}

/** The frames of the edited document in which the edit is seen. */
export function seenFrames(
  kind: Kind,
  { factors }: Choices,
  [first, last]: [number, number],
): Pick<Seen, "first" | "last"> {
  if (kind === "loop") return { first: 1 };
  return { first, last: kind === "speed" ? first + framesAt(last - first + 1, factors) - 1 : last };
}
