/** Parts of a body that are moved over frames, as the edit `pose` has them. Pure functions. */
import type { Schemas } from "../../../api/client";
import type { Vector } from "../../../motion/body/quaternions";
import type { Skeleton } from "../../../motion/body/skeleton";
import type { Edits } from "../timeline/edits";

export type HandleName = Schemas["MovedHandle"]["handle"];

/** The joint that each handle moves, from the trunk outwards. */
export const JOINTS: Readonly<Record<HandleName, string>> = {
  hips: "Root",
  head: "Head",
  left_hand: "left_hand",
  right_hand: "right_hand",
  left_foot: "left_foot",
  right_foot: "right_foot",
};

export interface Moved {
  /** In the unit and axes of the document. */
  move: Vector;
  /** A rotation vector in degrees. */
  turn: Vector;
}

export const STILL: Moved = { move: [0, 0, 0], turn: [0, 0, 0] };

export const isStill = ({ move, turn }: Moved): boolean => [...move, ...turn].every((one) => one === 0);

/** The handles of a skeleton: hands and feet need the whole limb. */
export const handlesOf = ({ byName }: Pick<Skeleton, "byName">): HandleName[] =>
  (Object.keys(JOINTS) as HandleName[]).filter((name) => {
    const [side, part] = name.split("_");
    const limb = part && (part === "hand" ? "arm" : "leg");
    const above = limb ? [`${side}_up_${limb}`, `${side}_low_${limb}`] : ["Root"];
    return [...above, JOINTS[name]].every((joint) => byName.has(joint));
  });

/** The handle that moves a joint. */
export const handleOf = (joint: string | undefined): HandleName | null =>
  (Object.keys(JOINTS) as HandleName[]).find((name) => JOINTS[name] === joint) ?? null;

export interface PoseChoices {
  moves: ReadonlyMap<HandleName, Moved>;
  /** Frames of the whole pose, positions from 1. */
  range: readonly [number, number];
  /** Frames before and after over which it comes and goes. */
  fade: number;
  keepFeet: boolean;
}

/** The edit of a document of so many frames; null where nothing is moved. */
export function poseEdit({ moves, range, fade, keepFeet }: PoseChoices, frames: number): Edits | null {
  const handles = [...moves].filter(([, moved]) => !isStill(moved)).map(([handle, moved]) => ({ handle, ...moved }));
  if (!handles.length) return null;
  const [first, last] = fadedRange(range, fade, frames);
  const hold: HandleName[] = keepFeet ? ["left_foot", "right_foot"] : [];
  return [{ do: "pose", first, last, handles, hold, ease: fade }];
}

/** The frames that change, positions from 1. */
export const fadedRange = (
  [first, last]: readonly [number, number],
  fade: number,
  frames: number,
): [number, number] => [Math.max(1, first - fade), Math.min(frames, last + fade)];
