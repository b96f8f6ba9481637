/** Another revision beside the open one: which frame of it is which, and how far its joints are away. */
import { get, type Schemas } from "../../api/client";
import { alignedBy, earlierRows, pairsOf, turned, type At, type Kept } from "../../motion/comparison/aligned";
import { Blocks, positionsOf } from "../../motion/loading/blocks";
import { skeletonOf, type Skeleton } from "../../motion/body/skeleton";
import { w } from "../../words";
import { note } from "../session/notes";

/** The open clip, as far as another revision is compared with it. */
export interface Opened {
  id: string;
  frames: number;
  blocks: Blocks;
  skeleton: Skeleton;
  detail: { revision: number };
  player: { frame: { peek: () => number } };
}

interface Pose {
  revision: number;
  frames: number;
  blocks: Blocks;
  origin: readonly number[];
}

/** The revision of the ghost. */
export interface Compared extends Pose {
  /** What it is compared with; null: the open revision. */
  against: Pose | null;
  /** Position of a frame of the open revision in this one. */
  at: At;
  /** Position in the open revision of a frame of the one that this is compared with. */
  seekAt: At;
  /** Rows of this revision for those of the overview of the one that it is compared with; NaN where it has none. */
  rows: Float32Array;
  facts: { same: number; removed: number; added: number; byPosition: boolean };
}

/** Null where the revisions have other joints, which is told. */
export async function compareRevisions(
  clip: Opened,
  revision: number,
  against: number | null,
  signal: AbortSignal,
): Promise<Compared | null> {
  const open: Pose = {
    revision: clip.detail.revision,
    frames: clip.frames,
    blocks: clip.blocks,
    origin: clip.skeleton.view.origin,
  };
  const [then, other] = await Promise.all([
    poseOf(clip, revision, signal),
    against === null ? null : poseOf(clip, against, signal),
  ]);
  if (!then || (against !== null && !other)) return null;
  const newer = other ?? open;
  const pairs = await keptOf(clip.id, then, newer, signal);
  const toOpen = other ? await keptOf(clip.id, then, open, signal) : pairs;
  const seeks = other ? await keptOf(clip.id, open, other, signal) : null;
  const shift = then.origin.map((one, axis) => one - newer.origin[axis]!);
  const rows = await earlierRows(then.blocks.source, pairs.kept, newer.frames, newer.blocks.coarseStep, shift, signal);
  newer.blocks.want(clip.player.frame.peek());
  const same = pairs.kept.reduce((sum, one) => sum + one.count, 0);
  return {
    ...then,
    against: other,
    at: alignedBy(toOpen.kept),
    seekAt: seeks ? alignedBy(seeks.kept) : (frame) => frame,
    rows,
    facts: { same, removed: then.frames - same, added: newer.frames - same, byPosition: pairs.byPosition },
  };
}

async function poseOf(clip: Opened, revision: number, signal: AbortSignal): Promise<Pose | null> {
  const skeleton = skeletonOf(
    await get("/documents/{id}/skeleton", { path: { id: clip.id }, query: { revision }, signal }),
  );
  const names = (view: Schemas["SkeletonView"]) =>
    JSON.stringify([view.bones.map((bone) => bone.name), view.tips.length]);
  if (names(skeleton.view) !== names(clip.skeleton.view)) {
    note(w("error.otherJoints", { n: revision }), { bad: true });
    return null;
  }
  return {
    revision,
    frames: skeleton.view.frames,
    blocks: new Blocks(positionsOf(clip.id, revision, skeleton)),
    origin: skeleton.view.origin,
  };
}

/** Frames that two revisions share: `before` in the first one, `after` in the second, whichever is the older. */
async function keptOf(
  id: string,
  one: Pose,
  other: Pose,
  signal: AbortSignal,
): Promise<{ kept: Kept[]; byPosition: boolean }> {
  if (one.revision === other.revision) return { kept: [{ before: 1, after: 1, count: one.frames }], byPosition: false };
  const [before, after] = [one.revision, other.revision].sort((a, b) => a - b) as [number, number];
  const told = await get("/documents/{id}/difference", { path: { id }, query: { before, after }, signal });
  const kept = before === one.revision ? told.frames_kept : turned(told.frames_kept);
  return { kept: pairsOf(kept, one.frames, other.frames), byPosition: !kept.length && one.frames === other.frames };
}
