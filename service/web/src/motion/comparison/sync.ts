/** Which frame of one clip is shown beside a frame of another. Frames from 0, spans' from 1. */
import { itemAt } from "../../lists";

export type Sync = "time" | "frame" | "span";

export interface Timed {
  frames: number;
  perSecond: number;
  labels: readonly { name: string; first: number; last: number }[];
}

/** Two frames that stand side by side; from them on both run. */
export interface Anchor {
  here: number;
  there: number;
}

const START: Anchor = { here: 0, there: 0 };

/** Where two clips begin together. By span: the last one that began at `frame` or before and whose name the other clip
 * has too, else the first such; the nth of a name meets the other's nth, or its last. */
export function anchorOf(here: Timed, there: Timed, sync: Sync, frame: number): Anchor {
  if (sync !== "span") return START;
  const nth = new Map<string, number>();
  const pairs: Anchor[] = [];
  for (const span of inOrder(here)) {
    const count = nth.get(span.name) ?? 0;
    nth.set(span.name, count + 1);
    const same = inOrder(there).filter((one) => one.name === span.name);
    if (same.length)
      pairs.push({ here: span.first - 1, there: itemAt(same, Math.min(count, same.length - 1)).first - 1 });
  }
  return pairs.findLast((pair) => pair.here <= frame) ?? pairs[0] ?? START;
}

const inOrder = (clip: Timed) => [...clip.labels].sort((a, b) => a.first - b.first || a.last - b.last);

/** The frame of `there` beside a frame of `here`; its first or last where it has no more. */
export function frameBeside(
  here: Timed,
  there: Timed,
  sync: Sync,
  frame: number,
  anchor = anchorOf(here, there, sync, frame),
): number {
  const seconds = (frame - anchor.here) / here.perSecond;
  const by = sync === "frame" ? frame - anchor.here : Math.floor(seconds * there.perSecond + 1e-6);
  return Math.max(0, Math.min(there.frames - 1, anchor.there + by));
}
