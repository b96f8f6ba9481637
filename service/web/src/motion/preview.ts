/** Motion that is not stored: the server makes it for an eye's worth, as positions at even steps. */
import { address, fetched } from "../api/client";
import type { Skeleton } from "./skeleton";

const MOST_BYTES = 6 << 20;

/** Positions at every `step`-th frame, (n, points, 3); between them straight lines are drawn. */
export class Preview {
  constructor(
    readonly skeleton: Skeleton,
    readonly frames: number,
    readonly perSecond: number,
    private readonly values: Float32Array,
    private readonly step: number,
  ) {}

  frame(index: number): Float32Array {
    const stride = this.skeleton.points * 3;
    const rows = this.values.length / stride;
    const exact = Math.max(0, Math.min(rows - 1, index / this.step));
    const row = Math.floor(exact);
    const share = exact - row;
    if (!share || row + 1 >= rows) return this.values.subarray(row * stride, (row + 1) * stride);
    const found = new Float32Array(stride);
    for (let at = 0; at < stride; at++) found[at] = this.values[row * stride + at] * (1 - share) + this.values[(row + 1) * stride + at] * share;
    return found;
  }
}

/** The motion that a request would make. path: of the operation; the answer's shape stands in its header. */
export async function previewOf(path: string, body: object, skeleton: Skeleton, frames: number, perSecond: number, stop: AbortSignal): Promise<Preview> {
  const step = Math.max(1, Math.ceil((frames * skeleton.points * 12) / MOST_BYTES));
  const answer = await fetched(address(path, {}, { step }), { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body), signal: stop });
  return new Preview(skeleton, frames, perSecond, new Float32Array(await answer.arrayBuffer()), step);
}
