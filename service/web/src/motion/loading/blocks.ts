/**
 * Positions of a clip's points, fetched in blocks of 256 frames as plain float32 and kept while there is room.
 *
 * First the block that is looked at, then one coarse pass over the whole clip, so that every moment has a pose at once,
 * then what comes next in playing direction. A jump elsewhere drops what is no longer wanted.
 */
import { signal } from "@preact/signals";
import { address, fetched } from "../../api/client";
import type { Skeleton } from "../body/skeleton";

export const BLOCK = 256;
const AT_ONCE = 4;
const COARSE_BYTES = 1 << 20;
const AHEAD_SECONDS = 2;
const OVERVIEW = -1;
const ROOM = (((navigator as { deviceMemory?: number }).deviceMemory ?? 8) <= 4 ? 96 : 192) << 20;

/** All blocks of the page, the least recently used first. */
const kept = new Map<string, { bytes: number; drop: () => void }>();
let total = 0;

let opened = 0;

export const keptBytes = (): number => total;

function keep(key: string, bytes: number, drop: () => void): void {
  forget(key);
  kept.set(key, { bytes, drop });
  total += bytes;
  for (const [oldest, entry] of kept) {
    if (total <= ROOM || oldest === key) break;
    forget(oldest);
    entry.drop();
  }
}

function forget(key: string): void {
  total -= kept.get(key)?.bytes ?? 0;
  kept.delete(key);
}

function touch(key: string): void {
  const entry = kept.get(key);
  if (!entry) return;
  kept.delete(key);
  kept.set(key, entry);
}

type Numbers = Float32Array | Float64Array;

/** What blocks hold: numbers a frame, whether a coarse pass is worth it, and how they are fetched. */
export interface Source<T extends Numbers> {
  frames: number;
  stride: number;
  coarse: boolean;
  fetch: (span: Span, signal: AbortSignal) => Promise<T>;
}

export interface Span {
  /** From 1, both ends included. */
  first: number;
  last?: number;
  step?: number;
}

export class Blocks<T extends Numbers = Float32Array> {
  /** Moves whenever frames came in. */
  readonly arrived = signal(0);
  readonly trouble = signal<unknown>(null);
  private readonly blocks = new Map<number, T>();
  private readonly asked = new Map<number, AbortController>();
  private queue: number[] = [];
  private coarse: T | null = null;
  /** Frames between two rows of `overview`. */
  readonly coarseStep: number;
  private closed = false;
  /** Two views of one clip have their own blocks. */
  private readonly number = ++opened;

  constructor(readonly source: Source<T>) {
    const bytes = source.frames * source.stride * 4;
    this.coarseStep = source.coarse ? Math.max(1, Math.ceil(bytes / COARSE_BYTES)) : 1;
  }

  /** The numbers of a frame (from 0), as a view of its block; of a near one while it is on its way; null before
   * anything came. */
  frame(index: number): T | null {
    const number = Math.floor(index / BLOCK);
    const block = this.blocks.get(number);
    if (block) return this.row(block, index - number * BLOCK);
    if (!this.coarse) return null;
    return this.row(
      this.coarse,
      Math.min(Math.round(index / this.coarseStep), this.coarse.length / this.source.stride - 1),
    );
  }

  private row(block: T, place: number): T {
    return block.subarray(place * this.source.stride, (place + 1) * this.source.stride) as T;
  }

  has(index: number): boolean {
    return this.blocks.has(Math.floor(index / BLOCK));
  }

  /** Poses over the whole clip, once they are there: rows `step` frames apart. */
  overview(): { values: T; step: number } | null {
    return this.coarse && { values: this.coarse, step: this.coarseStep };
  }

  /** Fetch what is looked at and what comes next. direction: -1 backwards, 0 still, 1 forwards. */
  want(index: number, direction = 0, perSecond = 0, loopStart = index): void {
    if (this.closed) return;
    const here = Math.floor(index / BLOCK);
    const last = Math.ceil(this.source.frames / BLOCK) - 1;
    const ahead = perSecond ? Math.max(1, Math.ceil((AHEAD_SECONDS * perSecond) / BLOCK)) : 0;
    const next = Array.from({ length: ahead }, (_, by) => here + (by + 1) * (direction || 1));
    const inside = (blocks: number[]) =>
      blocks.filter((block) => block >= 0 && block <= last && !this.blocks.has(block));
    const overview = !this.coarse && this.source.coarse && last > 0 ? [OVERVIEW] : [];
    const wanted = [
      ...new Set([...inside([here]), ...overview, ...inside(next), ...inside([Math.floor(loopStart / BLOCK)])]),
    ];
    for (const [block, stop] of this.asked) {
      if (wanted.includes(block) || block === OVERVIEW) continue;
      stop.abort();
      this.asked.delete(block);
    }
    touch(this.key(here));
    this.queue = wanted.filter((block) => !this.asked.has(block));
    this.pump();
  }

  close(): void {
    this.closed = true;
    this.queue = [];
    for (const stop of this.asked.values()) stop.abort();
    for (const block of this.blocks.keys()) forget(this.key(block));
    this.blocks.clear();
    this.coarse = null;
  }

  private key(block: number): string {
    return `${this.number}#${block}`;
  }

  private pump(): void {
    while (this.queue.length && this.asked.size < AT_ONCE) void this.load(this.queue.shift()!);
  }

  private async load(block: number): Promise<void> {
    const stop = new AbortController();
    this.asked.set(block, stop);
    const { frames } = this.source;
    try {
      const span =
        block === OVERVIEW
          ? { first: 1, step: this.coarseStep }
          : { first: block * BLOCK + 1, last: Math.min(frames, (block + 1) * BLOCK) };
      const values = await this.source.fetch(span, stop.signal);
      if (this.closed) return;
      if (block === OVERVIEW) this.coarse = values;
      else {
        this.blocks.set(block, values);
        keep(this.key(block), values.byteLength, () => this.blocks.delete(block));
        if (frames <= BLOCK) this.coarse = values;
      }
      this.trouble.value = null;
      this.arrived.value++;
    } catch (error) {
      if ((error as Error).name !== "AbortError") this.trouble.value = error;
    } finally {
      if (this.asked.get(block) === stop) this.asked.delete(block);
      this.pump();
    }
  }
}

/** Positions of joints and tips from the clip's origin: (frames, points, 3). NaN where nothing was recorded. */
export const positionsOf = (id: string, revision: number, skeleton: Skeleton): Source<Float32Array> => ({
  frames: skeleton.view.frames,
  stride: skeleton.points * 3,
  coarse: true,
  fetch: async (span, signal) => {
    const query = {
      revision,
      ...span,
      space: "positions",
      format: "block",
      dtype: "f4",
      origin: "subtract",
      missing: "nan",
      tips: true,
    };
    return new Float32Array(await bytes(id, query, signal));
  },
});

/** Rotations of joints from rest in the world: (frames, joints, 4). NaN as above. */
export const rotationsOf = (id: string, revision: number, skeleton: Skeleton): Source<Float32Array> => ({
  frames: skeleton.view.frames,
  stride: skeleton.view.bones.length * 4,
  coarse: false,
  fetch: async (span, signal) => {
    const query = { revision, ...span, space: "rotations", format: "block", dtype: "f4", missing: "nan" };
    return new Float32Array(await bytes(id, query, signal));
  },
});

/** Positions of the joints of a character that wears a clip, in its own unit and axes: (frames, joints, 3). */
export const wornPositionsOf = (id: string, revision: number, character: string, size: Size): Source<Float32Array> =>
  wornOf(id, revision, character, size, "positions", 3);

/** Their rotations from rest in the world: (frames, joints, 4). */
export const wornRotationsOf = (id: string, revision: number, character: string, size: Size): Source<Float32Array> =>
  wornOf(id, revision, character, size, "rotations", 4);

interface Size {
  frames: number;
  joints: number;
}

const wornOf = (
  id: string,
  revision: number,
  character: string,
  { frames, joints }: Size,
  space: string,
  width: number,
): Source<Float32Array> => ({
  frames,
  stride: joints * width,
  coarse: false,
  fetch: async (span, signal) => {
    const query = { revision, ...span, character, space, format: "block", dtype: "f4", missing: "nan" };
    return new Float32Array(await bytes(id, query, signal));
  },
});

/** Positions of every step-th frame of a clip where the file has them: (frames, points, 3), NaN as above. */
export async function sampledOf(
  id: string,
  revision: number,
  step: number,
  signal: AbortSignal,
): Promise<Float32Array> {
  const query = { revision, step, space: "positions", format: "block", dtype: "f4", missing: "nan", tips: true };
  return new Float32Array(await bytes(id, query, signal));
}

/** Channels as they are stored: (frames, columns of the skeleton). */
export const channelsOf = (id: string, revision: number, skeleton: Skeleton): Source<Float64Array> => ({
  frames: skeleton.view.frames,
  stride: skeleton.view.columns.length,
  coarse: false,
  fetch: async (span, signal) =>
    new Float64Array(await bytes(id, { revision, ...span, format: "block", dtype: "f8" }, signal)),
});

/** Quantities of the file or of the body: (frames, quantities). NaN where unknown. */
export const quantitiesOf = (
  id: string,
  revision: number,
  frames: number,
  quantity: readonly string[],
): Source<Float32Array> => ({
  frames,
  stride: quantity.length,
  coarse: false,
  fetch: async (span, signal) =>
    new Float32Array(await bytes(id, { revision, ...span, quantity, format: "block", dtype: "f4" }, signal)),
});

/** The channels of one bone over the whole clip: (frames, channels). */
export async function curvesOf(id: string, revision: number, bone: string, signal: AbortSignal): Promise<Float64Array> {
  return new Float64Array(await bytes(id, { revision, bone, format: "block", dtype: "f8" }, signal));
}

/** A quantity of the body (`height:left_hand`) in all frames, NaN where unknown: (frames,). */
export async function quantityOf(
  id: string,
  revision: number,
  quantity: string,
  signal: AbortSignal,
): Promise<Float64Array> {
  return new Float64Array(await bytes(id, { revision, quantity, format: "block", dtype: "f8" }, signal));
}

async function bytes(id: string, query: object, signal: AbortSignal): Promise<ArrayBuffer> {
  return (await fetched(address("/documents/{id}/frames", { id }, query), { signal })).arrayBuffer();
}
