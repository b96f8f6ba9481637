// @vitest-environment happy-dom
import { itemAt, numberAt } from "../../lists";
import { afterEach, describe, expect, it, vi } from "vitest";
import { BLOCK, Blocks, channelsOf, keptBytes, positionsOf, type Source, type Span } from "./blocks";
import type { Skeleton } from "../body/skeleton";

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));
const value = (frame: number, column: number) => frame + column / 1000; // frame from 0

/** A server whose answers wait until they are let go. */
class Server {
  asked: { span: Span; signal: AbortSignal; answer: () => void; fail: (error: Error) => void }[] = [];
  open: Blocks[] = [];

  source(frames: number, { stride = 3, coarse = true } = {}): Source<Float32Array> {
    const fetch = (span: Span, signal: AbortSignal) =>
      new Promise<Float32Array>((resolve, reject) => {
        const { first, last = frames, step = 1 } = span;
        const rows = Array.from({ length: Math.ceil((last - first + 1) / step) }, (_, row) => first - 1 + row * step);
        const answer = () => {
          const values = new Float32Array(rows.length * stride);
          if (stride < 1000)
            rows.forEach((frame, row) => {
              for (let column = 0; column < stride; column++) values[row * stride + column] = value(frame, column);
            });
          resolve(values);
        };
        signal.addEventListener("abort", () => reject(new DOMException("aborted", "AbortError")));
        this.asked.push({ span, signal, answer, fail: reject });
      });
    return { frames, stride, coarse, fetch };
  }

  blocks(frames: number, more: { stride?: number; coarse?: boolean } = {}): Blocks {
    const made = new Blocks(this.source(frames, more));
    this.open.push(made);
    return made;
  }

  /** What is on its way, in the order in which it was asked: numbers of blocks, or "coarse". */
  get waiting(): (number | "coarse")[] {
    return this.asked
      .filter(({ signal }) => !signal.aborted)
      .map(({ span }) => (span.last === undefined ? "coarse" : (span.first - 1) / BLOCK));
  }

  async answerAll(): Promise<void> {
    while (this.asked.length) {
      for (const one of this.asked.splice(0)) one.answer();
      await settled();
    }
  }
}

let server = new Server();
afterEach(() => {
  for (const one of server.open) one.close();
  expect(keptBytes()).toBe(0);
  server = new Server();
  vi.unstubAllGlobals();
});

describe("the order in which frames are fetched", () => {
  it("is what is looked at, the coarse pass, what comes next, the loop's start: four at once", async () => {
    const blocks = server.blocks(100 * BLOCK);
    blocks.want(50 * BLOCK + 7, 1, 600, 3 * BLOCK);
    expect(server.waiting).toEqual([50, "coarse", 51, 52]);
    itemAt(server.asked, 0).answer();
    await settled();
    expect(server.waiting.slice(1)).toEqual(["coarse", 51, 52, 53]);
    await server.answerAll();
    expect([50, 51, 52, 53, 54, 55, 56, 3, 49].map((block) => blocks.has(block * BLOCK))).toEqual([
      true,
      true,
      true,
      true,
      true,
      true,
      false,
      true,
      false,
    ]);
  });

  it("turns around where the motion plays backwards, and stays inside the clip", async () => {
    const blocks = server.blocks(10 * BLOCK, { coarse: false });
    blocks.want(1 * BLOCK, -1, 512, 0);
    expect(server.waiting).toEqual([1, 0]);
    await server.answerAll();
    expect(blocks.overview()).toBeNull();
    blocks.want(10 * BLOCK - 1, 1, 2000);
    expect(server.waiting).toEqual([9]);
  });

  it("asks for the last block no farther than the clip goes", async () => {
    const blocks = server.blocks(2 * BLOCK + 10, { coarse: false });
    blocks.want(2 * BLOCK + 3);
    expect(itemAt(server.asked, 0).span).toEqual({ first: 2 * BLOCK + 1, last: 2 * BLOCK + 10 });
  });

  it("needs no coarse pass where all is one block", () => {
    server.blocks(BLOCK).want(0);
    expect(server.waiting).toEqual([0]);
  });

  it("asks for nothing twice", async () => {
    const blocks = server.blocks(20 * BLOCK);
    for (let frame = 0; frame < 200; frame += 7) blocks.want(frame, 1, 60);
    await server.answerAll();
    const before = blocks.arrived.value;
    blocks.want(10, 1, 60);
    expect(server.asked).toEqual([]);
    expect(blocks.arrived.value).toBe(before);
  });
});

describe("a jump elsewhere", () => {
  it("aborts what is no longer wanted, keeps the coarse pass, and what is wanted still", async () => {
    const blocks = server.blocks(100 * BLOCK);
    blocks.want(10 * BLOCK, 1, 600, 10 * BLOCK);
    expect(server.waiting).toEqual([10, "coarse", 11, 12]);
    blocks.want(12 * BLOCK, 1, 300, 12 * BLOCK);
    expect(server.waiting).toEqual(["coarse", 12, 13, 14]);
    blocks.want(80 * BLOCK);
    expect(server.waiting).toEqual(["coarse", 80]);
    await server.answerAll();
    expect(blocks.trouble.value).toBeNull();
    expect([10, 11, 12, 80].map((block) => blocks.has(block * BLOCK))).toEqual([false, false, false, true]);
  });

  it("and back again asks anew", async () => {
    const blocks = server.blocks(100 * BLOCK, { coarse: false });
    blocks.want(0);
    blocks.want(50 * BLOCK);
    blocks.want(0);
    expect(server.waiting).toEqual([0]);
    await server.answerAll();
    expect(blocks.has(0)).toBe(true);
  });
});

describe("a frame", () => {
  it("is exact once its block is there, a near one before, and nothing before anything came", async () => {
    const [frames, stride] = [3000, 300];
    const blocks = server.blocks(frames, { stride });
    expect(blocks.frame(2000)).toBeNull();
    blocks.want(0);
    await server.answerAll();
    const { values, step } = blocks.overview()!;
    expect(step).toBe(Math.ceil((frames * stride * 4) / (1 << 20)));
    expect(values.length / stride).toBe(Math.ceil(frames / step));
    for (let frame = 0; frame < frames; frame++) {
      const row = blocks.frame(frame)!;
      expect(row.length).toBe(stride);
      if (blocks.has(frame))
        expect([row[0], row[stride - 1]]).toEqual([value(frame, 0), value(frame, stride - 1)].map(Math.fround));
      else expect(Math.abs(numberAt(row, 0) - frame)).toBeLessThanOrEqual(step);
    }
  });
});

describe("memory", () => {
  const STRIDE = 16_384; // 16 MiB a block
  const room = 192 << 20;

  it("has a limit; the least recently used goes first", async () => {
    const blocks = server.blocks(40 * BLOCK, { stride: STRIDE, coarse: false });
    for (let block = 0; block < 12; block++) {
      blocks.want(block * BLOCK);
      await server.answerAll();
    }
    expect(keptBytes()).toBe(room);
    blocks.want(0); // used again
    blocks.want(12 * BLOCK);
    await server.answerAll();
    expect(keptBytes()).toBe(room);
    expect([0, 1, 2, 12].map((block) => blocks.has(block * BLOCK))).toEqual([true, false, true, true]);
    blocks.want(1 * BLOCK);
    expect(server.waiting).toEqual([1]);
  });

  it("is shared by all that is open, and given back when it is closed, also by two views of one clip", async () => {
    const [one, two] = [
      server.blocks(8 * BLOCK, { stride: STRIDE, coarse: false }),
      server.blocks(8 * BLOCK, { stride: STRIDE, coarse: false }),
    ];
    for (const blocks of [one, two]) {
      for (let block = 0; block < 8; block++) {
        blocks.want(block * BLOCK);
        await server.answerAll();
      }
    }
    const held = (blocks: Blocks) =>
      Array.from({ length: 8 }, (_, block) => blocks.has(block * BLOCK)).filter(Boolean).length;
    expect(held(one) + held(two)).toBe(12);
    expect(keptBytes()).toBe(room);
    one.close();
    expect(keptBytes()).toBe(held(two) * (16 << 20));
    two.close();
    expect(keptBytes()).toBe(0);
  });
});

describe("what fails", () => {
  it("is told, asked for again by the next look, and forgotten once it came", async () => {
    const blocks = server.blocks(5 * BLOCK, { coarse: false });
    blocks.want(0);
    server.asked.pop()!.fail(new Error("503"));
    await settled();
    expect((blocks.trouble.value as Error).message).toBe("503");
    blocks.want(1);
    await server.answerAll();
    expect(blocks.trouble.value).toBeNull();
    expect(blocks.has(0)).toBe(true);
  });
});

describe("after it is closed", () => {
  it("nothing is asked for, kept or told", async () => {
    const blocks = server.blocks(100 * BLOCK);
    blocks.want(10 * BLOCK, 1, 1200);
    const count = server.asked.length;
    blocks.close();
    await settled();
    expect(server.asked.length).toBe(count);
    expect(server.waiting).toEqual([]);
    blocks.want(0);
    await server.answerAll();
    expect(keptBytes()).toBe(0);
    expect(blocks.trouble.value).toBeNull();
    expect(blocks.frame(0)).toBeNull();
  });
});

describe("the addresses of numbers", () => {
  it("name the revision, so that they are kept for good, and the frames", async () => {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (url: string) => {
      asked.push(url);
      return new Response(new Uint8Array(new Float64Array([1, 2, 3]).buffer));
    });
    const skeleton = {
      points: 2,
      view: { frames: 1000, columns: ["a.Tx", "a.Ty", "a.Tz", "b.Rx"] },
    } as unknown as Skeleton;
    const positions = positionsOf("u", 4, skeleton);
    expect([positions.stride, positions.frames, positions.coarse]).toEqual([6, 1000, true]);
    expect((await positions.fetch({ first: 257, last: 512 }, new AbortController().signal)).length).toBe(6);
    const channels = channelsOf("u", 4, skeleton);
    expect([channels.stride, channels.coarse]).toEqual([4, false]);
    expect([...(await channels.fetch({ first: 1, last: 256 }, new AbortController().signal))]).toEqual([1, 2, 3]);
    expect(asked).toEqual([
      "/api/v1/documents/u/frames?revision=4&first=257&last=512&space=positions&format=block&dtype=f4&origin=subtract&missing=nan&tips=true",
      "/api/v1/documents/u/frames?revision=4&first=1&last=256&format=block&dtype=f8",
    ]);
  });
});
