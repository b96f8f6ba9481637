// @vitest-environment happy-dom
import { afterEach, expect, it, vi } from "vitest";
import { itemAt } from "../../lists";
import { skeletonOf } from "../body/skeleton";
import { keptBytes } from "./blocks";
import { characterOf, forgetMissing, wornAt, type Character, type Wearer } from "./character";

afterEach(() => vi.unstubAllGlobals());

const view = (up: string, frames: number) => ({
  revision: 4,
  frames,
  bones: [{ name: "Root", parent: -1, side: "centre", offset: [0, 0, 0], channels: ["Tx"] }],
  tips: [],
  centres: [],
  lines: [],
  plates: [],
  columns: ["Root.Tx"],
  likely_up: up,
  likely_unit: "cm",
  unit: "cm",
  origin: [1, 2, 3],
});
const MESH = {
  points: [0, 0, 0, 1, 0, 0, 0, 1, 0],
  triangles: [0, 1, 2],
  joints: Array.from({ length: 12 }, () => 0),
  weights: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
  bind_positions: [[0, 0, 0]],
  bind_rotations: [[0, 0, 0, 1]],
};
const clip = (id: string): Wearer => ({
  id,
  revision: 1,
  skeleton: skeletonOf(view("Z", 2) as unknown as Parameters<typeof skeletonOf>[0]),
});

/** Answers of a server by the end of the path. */
function serve(answer: object, asked: string[] = []): string[] {
  vi.stubGlobal("fetch", async (url: string) => {
    asked.push(url);
    if (url.includes("/frames")) {
      const width = url.includes("space=positions") ? 3 : 4;
      return new Response(Float32Array.from({ length: 2 * width }, (_, at) => at).buffer);
    }
    return Response.json(url.includes("/skeleton") ? view("Y", 1) : answer);
  });
  return asked;
}

async function loaded(wearer: Wearer, chosen: string): Promise<Character> {
  const found = characterOf(wearer, chosen);
  await vi.waitFor(() => expect(found.value).not.toBeNull());
  return found.value!;
}

it("brings a character of the library with the frames of its own joints", async () => {
  const notes = ["17 joints matched"];
  const asked = serve({
    mesh: { ...MESH, colours: [255, 0, 0, 0, 255, 0, 0, 0, 255], normals: [0, 0, 1, 0, 0, 1, 0, 0, 1] },
    document: "avatar",
    revision: 4,
    scale: 0.5,
    notes,
  });
  const wearer = clip("worn");
  const body = await loaded(wearer, "avatar");
  expect(itemAt(asked, 0)).toContain("character=avatar");
  expect(body.notes).toEqual(notes);
  expect(body.skin?.own).toEqual({ metres: wearer.skeleton.metres / 0.5, zUp: false, origin: [1, 2, 3] });
  expect([...body.skin!.colours!.slice(0, 3)]).toEqual([255, 0, 0]);
  expect([...body.skin!.normals!.slice(0, 3)]).toEqual([0, 0, 1]);
  expect(wornAt(body, 1)).toBeNull();
  const { positions, rotations } = body.frames!;
  positions.want(0);
  rotations.want(0);
  await vi.waitFor(() => expect(wornAt(body, 1)).not.toBeNull());
  expect([...wornAt(body, 1)!.positions]).toEqual([3, 4, 5]);
  expect([...wornAt(body, 1)!.turns]).toEqual([4, 5, 6, 7]);
  const frames = asked.filter((url) => url.includes("/frames"));
  expect(frames.every((url) => url.includes("character=avatar") && url.includes("/worn/"))).toBe(true);
  // Blocks are counted for the whole page.
  positions.close();
  rotations.close();
  expect(keptBytes()).toBe(0);
});

it("brings the own body, which follows the joints of the clip", async () => {
  serve({ mesh: MESH, notes: [] });
  const body = await loaded(clip("own"), "");
  expect(body.skin?.own).toBeNull();
  expect(body.skin?.colours).toBeNull();
  expect(body.frames).toBeNull();
  expect(wornAt(body, 0)).toBeNull();
});

it("asks once, and again when it is wanted, for bodies that there are none of", async () => {
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (url: string) => {
    asked.push(url);
    return Response.json({ title: "Gone" }, { status: 404 });
  });
  const wearer = clip("missing");
  expect((await loaded(wearer, "gone")).reason).toBe("Gone");
  expect(characterOf(wearer, "gone").value?.skin).toBeNull();
  expect(asked.length).toBe(1);
  forgetMissing();
  serve({ mesh: null, reason: "Only 2 joints.", remedy: "Name them.", notes: [] }, asked);
  expect((await loaded(wearer, "gone")).reason).toBe("Only 2 joints. Name them.");
  expect(asked.length).toBe(2);
});
