/** Stored motion that pages besides the clip's own play: a skeleton with its blocks. Kept while it is used. */
import { get } from "../../api/client";
import { Blocks, positionsOf, rotationsOf } from "./blocks";
import { skeletonOf, type Skeleton } from "../body/skeleton";

export interface Motion {
  id: string;
  revision: number;
  name: string;
  skeleton: Skeleton;
  blocks: Blocks;
  /** Rotations of the joints, for bodies with a skin: fetched when they are wanted. */
  rotations: Blocks;
  frames: number;
  perSecond: number;
}

const USUAL_RATE = 30;
const MOST = 8;
const open = new Map<string, Promise<Motion>>();

/** The motion of a document, at a revision or the newest. */
export function motionOf(id: string, revision?: number): Promise<Motion> {
  const key = `${id}@${revision ?? ""}`;
  const before = open.get(key);
  if (before) {
    open.delete(key);
    open.set(key, before);
    return before;
  }
  const made = load(id, revision);
  open.set(key, made);
  made.catch(() => open.delete(key));
  if (open.size > MOST) {
    // A page may still show it; its blocks go when room is needed.
    open.delete(open.keys().next().value!);
  }
  return made;
}

/** What was edited is asked anew. */
export const forget = (id: string): void => {
  for (const key of open.keys()) if (key.startsWith(`${id}@`)) open.delete(key);
};

async function load(id: string, revision?: number): Promise<Motion> {
  const view = await get("/documents/{id}/skeleton", { path: { id }, query: revision ? { revision } : {} });
  const skeleton = skeletonOf(view);
  return {
    id,
    skeleton,
    revision: view.revision,
    name: view.name,
    blocks: new Blocks(positionsOf(id, view.revision, skeleton)),
    rotations: new Blocks(rotationsOf(id, view.revision, skeleton)),
    frames: view.frames,
    perSecond: 1 / (view.seconds_per_frame || 1 / USUAL_RATE),
  };
}
