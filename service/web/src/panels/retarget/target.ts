/** The body that a motion is brought to: that of a clip, or a known rig, of which only answers have positions. */
import type { Schemas } from "../../api/client";
import { bodyOf, numbersOf, type Told } from "../../motion/loading/preview";
import type { Motion } from "../../motion/loading/source";
import type { Skeleton } from "../../motion/body/skeleton";
import { itemAt } from "../../lists";

export interface Target {
  name: string;
  /** As a request names it. */
  asked: Pick<Schemas["RetargetRequest"], "skeleton"> | Pick<Schemas["RetargetRequest"], "to">;
  /** null: a known rig's. */
  skeleton: Skeleton | null;
  /** About how many points a frame has. */
  points: number;
}

export const targetOfClip = (motion: Motion): Target => ({
  name: motion.name,
  asked: { skeleton: motion.id },
  skeleton: motion.skeleton,
  points: motion.skeleton.points,
});

export const targetOfRig = (rig: Schemas["KnownRigInfo"]): Target => ({
  name: rig.title,
  asked: { to: rig.name },
  skeleton: null,
  points: 2 * rig.joints,
});

/** The skeleton of a target, that of a known rig from an answer with its positions. */
export const skeletonIn = (target: Target, told: Told | null | undefined): Skeleton | null =>
  target.skeleton ?? (told ? bodyOf(told, numbersOf(told), itemAt(told.shape, 0)) : null);
