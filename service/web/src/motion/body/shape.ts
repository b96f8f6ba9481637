/**
 * The bones of a skeleton at rest as a draft has them: lengths and offsets that are changed and not stored yet, and the
 * elements of the document that say them (docs/conventions.md).
 */
import { itemAt, numberAt } from "../../lists";
import { inverse, rotate, type Quaternion, type Vector } from "./quaternions";
import type { Skeleton, SkeletonView } from "./skeleton";

type Bone = SkeletonView["bones"][number];
type Changes = ReadonlyMap<string, { text?: string }>;
const DIGITS = 6;

/** The vector that a bone is changed by: from the joint above to its own, or (ASF) from its joint to its tip. Axes of the
 * world at rest. null: nothing that can be changed. */
export function vectorOf(view: SkeletonView, bone: number): Vector | null {
  const one = itemAt(view.bones, bone);
  if (one.convention === "fixed") return Math.hypot(...one.along) ? (one.along as Vector) : null;
  return one.convention !== "marker" && one.convention !== "shape" && one.parent >= 0 ? (one.offset as Vector) : null;
}

/** The joint that the vector begins at. */
export const baseOf = (view: SkeletonView, bone: number): number =>
  itemAt(view.bones, bone).convention === "fixed" ? bone : itemAt(view.bones, bone).parent;

/** The texts of elements that say a bone's vector. */
export function textsOf(view: SkeletonView, bone: number, vector: Vector): { address: string; text: string }[] {
  const one = itemAt(view.bones, bone);
  if (one.convention === "fixed") {
    const length = Math.hypot(...vector);
    if (!length) return [{ address: `${one.address}/length`, text: "0" }];
    return [
      { address: `${one.address}/direction`, text: written(vector.map((part) => part / length)) },
      { address: `${one.address}/length`, text: written([length]) },
    ];
  }
  const said =
    one.convention === "base" ? rotate(inverse(itemAt(view.bones, one.parent).axes as Quaternion), vector) : vector;
  return [{ address: `${one.address}/position`, text: written(said) }];
}

const written = (numbers: number[]): string => numbers.map((one) => String(Number(one.toFixed(DIGITS)))).join(" ");
const read = (text: string | undefined, count: number): number[] | null => {
  const numbers = (text ?? "")
    .trim()
    .split(/[\s,]+/)
    .map(Number);
  return numbers.length === count && text?.trim() && numbers.every(Number.isFinite) ? numbers : null;
};

/** The skeleton with the vectors that changed elements say; the same one where none does. */
export function reshaped(skeleton: Skeleton, changes: Changes): Skeleton {
  const { view } = skeleton;
  const vectors = new Map<number, Vector>();
  if (changes.size) {
    view.bones.forEach((bone, index) => {
      const found = vectorSaid(view, bone, changes);
      if (found) vectors.set(index, found);
    });
  }
  if (!vectors.size) return skeleton;
  const ends = (bone: number) => (view.bones[bone]?.convention === "fixed" ? vectors.get(bone) : undefined);
  const bones = view.bones.map((bone, index): Bone => {
    const own = vectors.get(index);
    if (bone.convention !== "fixed") return own ? { ...bone, offset: own } : bone;
    return { ...bone, along: own ?? bone.along, offset: ends(bone.parent) ?? bone.offset };
  });
  const tips = view.tips.map((tip) => ({ ...tip, offset: ends(tip.bone) ?? tip.offset }));
  return { ...skeleton, view: { ...view, bones, tips } };
}

function vectorSaid(view: SkeletonView, bone: Bone, changes: Changes): Vector | null {
  if (bone.convention === "fixed") {
    const direction = read(changes.get(`${bone.address}/direction`)?.text, 3);
    const length = read(changes.get(`${bone.address}/length`)?.text, 1);
    if (!direction && !length) return null;
    const towards = direction ?? bone.along;
    const norm = Math.hypot(...towards);
    return norm ? (towards.map((part) => (part / norm) * (length?.[0] ?? Math.hypot(...bone.along))) as Vector) : null;
  }
  const position =
    bone.parent >= 0 && bone.convention !== "marker" && bone.convention !== "shape"
      ? read(changes.get(`${bone.address}/position`)?.text, 3)
      : null;
  if (!position) return null;
  return bone.convention === "base"
    ? rotate(itemAt(view.bones, bone.parent).axes as Quaternion, position as Vector)
    : (position as Vector);
}

/** Where joints and tips are at rest, from the root: (points, 3). */
export function restOf({ view, points, parents }: Skeleton): Float32Array {
  const found = new Float32Array(points * 3);
  for (let point = 0; point < points; point++) {
    const offset =
      point < view.bones.length
        ? itemAt(view.bones, point).offset
        : itemAt(view.tips, point - view.bones.length).offset;
    for (let axis = 0; axis < 3; axis++)
      found[point * 3 + axis] =
        numberAt(parents, point) < 0
          ? 0
          : numberAt(found, numberAt(parents, point) * 3 + axis) + numberAt(offset, axis);
  }
  return found;
}
