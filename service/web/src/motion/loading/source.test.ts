// @vitest-environment happy-dom
import { itemAt } from "../../lists";
import { afterEach, expect, it, vi } from "vitest";
import { forget, motionOf, type Motion } from "./source";

afterEach(() => vi.unstubAllGlobals());

it("keeps what is shown, however many clips a page shows", async () => {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (url: string) => {
    asked.push(url);
    if (url.includes("/frames")) return new Response(new Uint8Array(new Float32Array([1, 2, 3]).buffer));
    const bone = { name: "Root", parent: -1, side: "centre", offset: [0, 0, 0], channels: ["Tx"] };
    return Response.json({
      revision: 2,
      name: "walk",
      frames: 1,
      seconds_per_frame: 0.01,
      bones: [bone],
      tips: [],
      centres: [],
      lines: [],
      columns: ["Root.Tx"],
      likely_up: "Y",
      origin: [0, 0, 0],
    });
  });
  const motions: Motion[] = [];
  for (let number = 0; number < 20; number++) motions.push(await motionOf(`clip-${number}`));
  expect(itemAt(motions, 0).perSecond).toBeCloseTo(100, 9);
  for (const motion of motions) motion.blocks.want(0);
  await vi.waitFor(() => expect(motions.every((motion) => motion.blocks.has(0))).toBe(true));
  expect([...itemAt(motions, 0).blocks.frame(0)!]).toEqual([1, 2, 3]);
  const before = asked.length;
  expect(await motionOf("clip-19")).toBe(motions[19]);
  expect(asked.length).toBe(before);
  forget("clip-19");
  expect(await motionOf("clip-19")).not.toBe(motions[19]);
  for (const motion of motions) motion.blocks.close();
});

it("asks again for what could not be had", async () => {
  vi.stubGlobal("fetch", async () => Response.json({ title: "Gone" }, { status: 404 }));
  await expect(motionOf("no")).rejects.toThrow("Gone");
  await expect(motionOf("no")).rejects.toThrow("Gone");
  await expect(motionOf("no", 3)).rejects.toThrow("Gone");
});
