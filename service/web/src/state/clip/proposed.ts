/** The motion that a proposal would make, beside the open one: which frame of it is which, and how far its joints are away. */
import { numberAt } from "../../lists";
import { get } from "../../api/client";
import { alignedBy, earlierRows, turned } from "../../motion/comparison/aligned";
import { Blocks, type Source } from "../../motion/loading/blocks";
import { numbersOf } from "../../motion/loading/preview";
import { w } from "../../words";
import { note } from "../session/notes";
import type { Compared, Opened } from "./compared";

const WINDOW = 4096; // frames of one answer

/** Null where the proposed motion has other joints, which is told. */
export async function compareProposal(clip: Opened, proposal: number, signal: AbortSignal): Promise<Compared | null> {
  const ask = (query: { first: number; last?: number; step?: number }, stop: AbortSignal) =>
    get("/documents/{id}/proposals/{proposal}/preview", {
      path: { id: clip.id, proposal },
      query: { positions: "f4" as const, ...query },
      signal: stop,
    });
  const told = await ask({ first: 1 }, signal);
  const { motion, frames } = told;
  const kept = turned(told.kept);
  if (!motion) return null;
  if (numberAt(motion.shape, 1) !== clip.skeleton.points) {
    note(w("error.proposalJoints", { n: proposal }), { bad: true });
    return null;
  }
  const windows = new Map<number, Promise<Float32Array>>([[0, Promise.resolve(numbersOf(motion))]]);
  const read = async (query: { first: number; last?: number; step?: number }, stop: AbortSignal) => {
    const found = (await ask(query, stop)).motion;
    return found ? numbersOf(found) : new Float32Array();
  };
  const source: Source<Float32Array> = {
    frames,
    stride: clip.skeleton.points * 3,
    coarse: true,
    fetch: async (span, stop) => {
      if ((span.step ?? 1) > 1) return read(span, stop);
      return windowed(span.first, span.last ?? frames, clip.skeleton.points * 3, (place) => {
        const first = place * WINDOW + 1;
        const found = windows.get(place) ?? read({ first, last: Math.min(frames, first + WINDOW - 1) }, signal);
        windows.set(place, found);
        return found;
      });
    },
  };
  const shift = motion.origin.map((one, axis) => one - numberAt(clip.skeleton.view.origin, axis));
  const rows = await earlierRows(source, kept, clip.frames, clip.blocks.coarseStep, shift, signal);
  const same = kept.reduce((sum, one) => sum + one.count, 0);
  const aligned = alignedBy(kept);
  return {
    revision: told.revision,
    frames,
    blocks: new Blocks(source),
    origin: motion.origin,
    against: null,
    // Where no frame is kept, as at another rate, both run in step from beginning to end.
    at: kept.length
      ? aligned
      : (frame) => Math.min(frames - 1, Math.round((frame * frames) / Math.max(1, clip.frames))),
    seekAt: (frame) => frame,
    rows,
    facts: { same, removed: clip.frames - same, added: frames - same, byPosition: false },
  };
}

/** Frames first to last of a motion that comes in windows. */
export async function windowed(
  first: number,
  last: number,
  stride: number,
  read: (window: number) => Promise<Float32Array>,
): Promise<Float32Array> {
  const found = new Float32Array(Math.max(0, last - first + 1) * stride);
  for (let place = Math.floor((first - 1) / WINDOW); place * WINDOW < last; place++) {
    const values = await read(place);
    const from = Math.max(first, place * WINDOW + 1);
    const to = Math.min(last, (place + 1) * WINDOW);
    const start = (from - 1 - place * WINDOW) * stride;
    found.set(values.subarray(start, start + (to - from + 1) * stride), (from - first) * stride);
  }
  return found;
}
