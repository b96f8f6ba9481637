/** What a body is led with: the rows of a selection, the positions of its clips, and its skeleton. */
import { address, ask, fetched, get } from "../../api/client";
import { itemAt } from "../../lists";
import { skeletonOf, type Skeleton } from "../../motion/body/skeleton";
import { sampledOf } from "../../motion/loading/blocks";
import { readNpy } from "../../motion/loading/npy";
import { Library, type Facts } from "../../motion/matching/library";
import type { Sampled } from "../../motion/matching/playing";
import type { Selection } from "../../ui/clips/ClipSelection";

export interface Loaded {
  library: Library;
  clips: Sampled[];
  skeleton: Skeleton;
  /** Of the whole selection. */
  facts: Facts;
  minutes: number;
  /** Whether clips of the selection were not loaded. */
  cut: boolean;
}

const MOST_ROWS = 54_000; // half an hour, some 25 MB of positions
const STRIDE = 31;

export async function load(
  selection: Selection,
  signal: AbortSignal,
  onProgress: (done: number, all: number) => void,
): Promise<Loaded> {
  const body = { selection: selection as never };
  const facts: Facts = await ask("post", "/motion-matching/library", { body, signal });
  const url = address("/motion-matching/library", {}, { format: "npy" });
  const answer = await fetched(url, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
    signal,
  });
  const rows = readNpy(await answer.arrayBuffer()).values as Float32Array;
  const within = facts.clips.filter((clip) => clip.last < MOST_ROWS);
  const used = within.length ? within : facts.clips.slice(0, 1);
  const first = itemAt(used, 0);
  const view = await get("/documents/{id}/skeleton", {
    path: { id: first.document },
    query: { revision: first.revision },
    signal,
  });
  const skeleton = skeletonOf(view);
  const clips: Sampled[] = [];
  for (const clip of used) {
    onProgress(clips.length, used.length);
    const step = Math.max(1, Math.round(1 / facts.rate / clip.seconds_per_frame));
    const values = await sampledOf(clip.document, clip.revision, step, signal);
    clips.push({ values, stride: skeleton.points * 3, step });
  }
  const count = itemAt(used, used.length - 1).last + 1;
  return {
    library: new Library({ ...facts, clips: used }, rows.subarray(0, count * STRIDE)),
    clips,
    skeleton,
    facts,
    minutes: count / facts.rate / 60,
    cut: used.length < facts.clips.length,
  };
}
