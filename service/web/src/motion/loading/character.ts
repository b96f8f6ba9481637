/** Bodies with a skin: to the measure of documents' skeletons, or characters of the library. Each is asked for once. */
import { signal, type ReadonlySignal, type Signal } from "@preact/signals";
import { get } from "../../api/client";
import type { Skeleton } from "../body/skeleton";
import { skinOf, type Skin, type Worn } from "../body/skin";
import { Blocks, wornPositionsOf, wornRotationsOf } from "./blocks";

export interface Character {
  skin: Skin | null;
  /** Why there is none, and what helps. */
  reason: string;
  /** What the character could not take over of the motion. */
  notes: readonly string[];
  /** Where its own joints are in each frame; null: it follows the joints of the clip. */
  frames: { positions: Blocks; rotations: Blocks } | null;
}

/** What wears the body: a document at a revision. */
export interface Wearer {
  id: string;
  revision: number;
  skeleton: Skeleton;
}

const MOST = 16;
const asked = new Map<string, Signal<Character | null>>();

/** The body of a document at a revision; null while it is on its way. chosen: the document of a character, "" for the
 * body to the measure of the skeleton. */
export function characterOf(wearer: Wearer, chosen: string): ReadonlySignal<Character | null> {
  const key = `${wearer.id}@${wearer.revision}:${chosen}`;
  const before = asked.get(key);
  if (before) return before;
  const made = signal<Character | null>(null);
  asked.set(key, made);
  const [oldest] = asked.keys();
  if (asked.size > MOST && oldest !== undefined) asked.delete(oldest);
  void load(wearer, chosen).then(
    (found) => (made.value = found),
    (error: unknown) => {
      made.value = { skin: null, reason: (error as Error).message, notes: [], frames: null };
    },
  );
  return made;
}

/** Ask again for bodies that there were none of. */
export function forgetMissing(): void {
  for (const [key, { value }] of asked) if (value && !value.skin) asked.delete(key);
}

async function load({ id, revision, skeleton }: Wearer, chosen: string): Promise<Character> {
  const query = { revision, ...(chosen && { character: chosen }) };
  const answer = await get("/documents/{id}/character", { path: { id }, query });
  const { mesh, document, scale, notes } = answer;
  const reason = [answer.reason, answer.remedy].filter(Boolean).join(" ");
  if (!mesh || !document || !scale) return { skin: mesh ? skinOf(mesh) : null, reason, notes, frames: null };
  const at = answer.revision ? { revision: answer.revision } : {};
  const rig = await get("/documents/{id}/skeleton", { path: { id: document }, query: at });
  const size = { frames: skeleton.view.frames, joints: rig.bones.length };
  const place = {
    metres: skeleton.metres / scale,
    zUp: rig.likely_up.endsWith("Z"),
    origin: skeleton.view.origin,
  };
  const frames = {
    positions: new Blocks(wornPositionsOf(id, revision, document, size)),
    rotations: new Blocks(wornRotationsOf(id, revision, document, size)),
  };
  return { skin: skinOf(mesh, place), reason, notes, frames };
}

/** Positions and rotations of a character's own joints in a frame; null while they are on their way. */
export function wornAt({ frames }: Character, frame: number): Worn | null {
  if (!frames?.positions.has(frame)) return null;
  const [positions, turns] = [
    frames.positions.frame(frame),
    frames.rotations.has(frame) && frames.rotations.frame(frame),
  ];
  return positions && turns ? { positions, turns } : null;
}
