import { numberAt } from "../../lists";
import { describe, expect, it, vi } from "vitest";
import { address, get } from "../../api/client";
import { BLOCK, Blocks, channelsOf, positionsOf } from "./blocks";
import { columnsOf, posed } from "../body/kinematics";
import { skeletonOf, type Skeleton } from "../body/skeleton";

// Node has its own fetch, but no older Node has a navigator.
vi.hoisted(() => {
  (globalThis as { navigator?: object }).navigator ??= {};
});
// A repository that the tests in Python serve, and what is in it.
const { MCML_SERVER, MCML_DOCUMENTS } = process.env;
const documents: [string, string][] = MCML_SERVER ? JSON.parse(MCML_DOCUMENTS!) : [];
const answers = globalThis.fetch;
if (MCML_SERVER)
  vi.stubGlobal("fetch", (url: string, init: RequestInit) => answers(`${MCML_SERVER}${url}`, { signal: init.signal }));

async function read(id: string, query: object): Promise<ArrayBuffer> {
  return (await fetch(address("/documents/{id}/frames", { id }, { format: "block", ...query }), {})).arrayBuffer();
}

/** The greatest extent of all points over all frames. */
function sizeOf(positions: Float64Array, skeleton: Skeleton): number {
  const sizes = [0, 1, 2].map((axis) => {
    let [least, most] = [Infinity, -Infinity];
    for (let at = axis; at < positions.length; at += 3) {
      if (numberAt(positions, at) < least) least = numberAt(positions, at);
      if (numberAt(positions, at) > most) most = numberAt(positions, at);
    }
    return most - least;
  });
  return Math.min(Math.max(...sizes), skeleton.height / skeleton.metres) || 1;
}

describe.skipIf(!documents.length)("what is drawn", () => {
  it.each(documents)("%s: is where the repository says that it is", async (_, id) => {
    const view = await get("/documents/{id}/skeleton", { path: { id } });
    const skeleton = skeletonOf(view);
    const columns = columnsOf(view);
    const positions = { space: "positions", origin: "subtract", tips: true, revision: view.revision };
    const seen = new Float64Array(await read(id, { ...positions, missing: "nan" }));
    const channels = new Float64Array(await read(id, { revision: view.revision }));
    const stride = skeleton.points * 3;
    expect([seen.length, channels.length]).toEqual([view.frames * stride, view.frames * columns.size]);
    const far = sizeOf(seen, skeleton) * 1e-4;
    let [worst, where, holes, all] = [0, "", 0, 0];
    for (let frame = 0; frame < view.frames; frame++) {
      const drawn = posed(skeleton, columns, channels.subarray(frame * columns.size, (frame + 1) * columns.size));
      expect(drawn.length).toBe(stride);
      for (let at = 0; at < stride; at++, all++) {
        const wanted = numberAt(seen, frame * stride + at);
        const away = Number.isNaN(wanted) && Number.isNaN(drawn[at]) ? 0 : Math.abs(wanted - numberAt(drawn, at));
        if (Number.isNaN(wanted)) holes++;
        if (away > worst || Number.isNaN(away))
          [worst, where] = [away, `frame ${frame + 1}, point ${Math.floor(at / 3)}: ${wanted} but ${drawn[at]}`];
        if (Number.isNaN(worst)) break;
      }
      if (Number.isNaN(worst)) break;
    }
    expect(worst, `${where}; a body of ${far * 1e4}; ${holes} of ${all} not seen`).toBeLessThan(far);
  });

  it.each(documents)("%s: comes to the viewer as the repository sends it", async (_, id) => {
    const view = await get("/documents/{id}/skeleton", { path: { id } });
    const skeleton = skeletonOf(view);
    for (const [source, query] of [
      [
        positionsOf(id, view.revision, skeleton),
        { space: "positions", origin: "subtract", tips: true, missing: "nan", dtype: "f4" },
      ],
      [channelsOf(id, view.revision, skeleton), { dtype: "f8" }],
    ] as const) {
      const bytes = await read(id, { ...query, revision: view.revision });
      const wanted = query.dtype === "f4" ? new Float32Array(bytes) : new Float64Array(bytes);
      const blocks = new Blocks<Float32Array | Float64Array>(source);
      for (let frame = 0; frame < view.frames; frame += BLOCK) {
        blocks.want(frame);
        await vi.waitFor(() => expect(blocks.has(frame)).toBe(true), { timeout: 10_000, interval: 2 });
      }
      for (let frame = 0; frame < view.frames; frame++) {
        const [row, whole] = [
          blocks.frame(frame)!,
          wanted.subarray(frame * source.stride, (frame + 1) * source.stride),
        ];
        if (row.length !== whole.length || row.some((value, at) => !Object.is(value, whole[at])))
          expect(row, `frame ${frame + 1}`).toEqual(whole);
      }
      expect(blocks.trouble.value).toBeNull();
      blocks.close();
    }
  });
});
