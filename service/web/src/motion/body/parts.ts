/** Parts of a body by the names of its bones: what a layer takes. */
import { itemAt } from "../../lists";
import type { SkeletonView } from "./skeleton";

export const PARTS = ["upper", "arms", "leftArm", "rightArm", "head", "legs"] as const;
export type Part = (typeof PARTS)[number];
type Bones = readonly Pick<SkeletonView["bones"][number], "name" | "parent" | "side">[];

const ARM = /arm|shoulder|clav|collar|humerus|elbow|wrist|hand|finger|thumb/i;
const LEG = /leg|thigh|femur|tibia|hip|knee|shin|foot|toe|ankle/i;
const HEAD = /neck|head|skull/i;

/** Names of the bones of each part; none where a body has no such part. */
export function partsOf(bones: Bones): Record<Part, string[]> {
  const below = (fits: (bone: Bones[number]) => boolean): boolean[] => {
    const inside: boolean[] = [];
    for (const [index, bone] of bones.entries())
      inside[index] = fits(bone) || (bone.parent >= 0 && itemAt(inside, bone.parent));
    return inside;
  };
  const names = (inside: boolean[]) => bones.filter((_, index) => inside[index]).map((bone) => bone.name);
  const arm = (side: string) => below((bone) => bone.side === side && ARM.test(bone.name));
  const [left, right] = [arm("left"), arm("right")];
  const legs = below((bone) => bone.side !== "centre" && LEG.test(bone.name) && !ARM.test(bone.name));
  return {
    upper: legs.some(Boolean) ? names(bones.map((bone, index) => !legs[index] && bone.parent >= 0)) : [],
    arms: names(left.map((one, index) => one || itemAt(right, index))),
    leftArm: names(left),
    rightArm: names(right),
    head: names(below((bone) => HEAD.test(bone.name))),
    legs: names(legs),
  };
}

/** The part that has exactly these bones. */
export function partNamed(bones: Bones, chosen: readonly string[]): Part | null {
  const wanted = [...chosen].sort().join();
  const found = partsOf(bones);
  return PARTS.find((part) => found[part].length > 0 && [...found[part]].sort().join() === wanted) ?? null;
}

/** What a layer takes at first: the upper body, or what comes nearest to it. */
export function usualPart(bones: Bones): string[] {
  const { upper, arms } = partsOf(bones);
  if (upper.length) return upper;
  return arms.length ? arms : bones.filter((bone) => bone.parent >= 0).map((bone) => bone.name);
}
