/**
 * Forward kinematics of one frame, for what is edited and not stored yet. The same as the server's
 * (mcml/motion/hub.py): P = P_parent + Q_parent t, Q = Q_parent L, with t and L made of channels by convention.
 */
import { itemAt, numberAt } from "../../lists";
import { IDENTITY, fixed, inverse, multiply, rotate, turning, type Quaternion, type Vector } from "./quaternions";
import type { Skeleton, SkeletonView } from "./skeleton";

type Bone = SkeletonView["bones"][number];

/** Where each channel stands among the numbers of a frame: "Root.Tx" to its place. */
export const columnsOf = (view: SkeletonView): Map<string, number> =>
  new Map(view.columns.map((column, place) => [column, place]));

/** Positions (points, 3) from the clip's origin. values: the frame's channels by column. NaN, as the server answers with
 * `missing=nan`, where a sample that a point hangs on is missing: of its joint, or of one above.
 *
 * turned: where rotations of the joints from rest in the world, (joints, 4), are written to, if they are wanted. */
export function posed(
  skeleton: Skeleton,
  columns: Map<string, number>,
  values: ArrayLike<number>,
  turned?: Float32Array,
): Float32Array {
  const { view } = skeleton;
  const positions = new Float32Array(skeleton.points * 3);
  const where: Vector[] = [];
  const turns: Quaternion[] = [];
  const scales: number[] = [];
  const hidden: boolean[] = [];
  view.bones.forEach((bone, index) => {
    const value = (channel: string): number | null => {
      const column = columns.get(`${bone.name}.${channel}`);
      const found = column === undefined ? null : values[column];
      return found === null || found === undefined || Number.isNaN(found) ? null : found;
    };
    scales.push(scaleOf(bone, value("SF")));
    hidden.push(
      (bone.parent >= 0 && hidden[bone.parent]) ||
        bone.convention === "shape" ||
        bone.channels.some((channel) => channel !== "residual" && value(channel) === null),
    );
    const above = view.bones[bone.parent] ?? null;
    const moved = translation(bone, above, above ? numberAt(scales, bone.parent) : 1, value);
    const local = rotation(bone, value, view.radians);
    if (above) {
      const turn = itemAt(turns, bone.parent);
      const step = rotate(turn, moved);
      const base = itemAt(where, bone.parent);
      where.push([base[0] + step[0], base[1] + step[1], base[2] + step[2]]);
      turns.push(multiply(turn, local));
    } else {
      where.push(moved);
      turns.push(local);
    }
    for (let axis = 0; axis < 3; axis++)
      positions[index * 3 + axis] = hidden[index]
        ? NaN
        : numberAt(itemAt(where, index), axis) - numberAt(view.origin, axis);
    turned?.set(itemAt(turns, index), index * 4);
  });
  view.tips.forEach((tip, place) => {
    const scale = numberAt(scales, tip.bone);
    const along = rotate(itemAt(turns, tip.bone), tip.offset.map((one) => one * scale) as Vector);
    for (let axis = 0; axis < 3; axis++) {
      positions[(view.bones.length + place) * 3 + axis] = hidden[tip.bone]
        ? NaN
        : numberAt(itemAt(where, tip.bone), axis) + numberAt(along, axis) - numberAt(view.origin, axis);
    }
  });
  return positions;
}

function scaleOf(bone: Bone, stated: number | null): number {
  if (stated === null) return 1;
  if (bone.convention !== "fixed") return stated;
  const length = Math.hypot(...bone.along);
  return length ? 1 + stated / length : 1;
}

function translation(bone: Bone, above: Bone | null, scale: number, value: (channel: string) => number | null): Vector {
  const rest = [...bone.offset] as Vector;
  const stated = (["Tx", "Ty", "Tz"] as const).map(value);
  if (bone.channels.some((channel) => channel[0] === "T")) {
    if (bone.convention === "fixed" && above)
      for (let axis = 0; axis < 3; axis++) rest[axis] = numberAt(rest, axis) * scale;
    if ((bone.convention === "listed" && bone.translation !== "relative") || bone.convention === "marker") {
      return rest.map((one, axis) => stated[axis] ?? one) as Vector;
    }
    let moved = stated.map((one) => one ?? 0) as Vector;
    if (bone.convention === "base" && above) moved = rotate(above.axes as Quaternion, moved);
    if (bone.convention === "fixed" && above) moved = rotate(bone.axes as Quaternion, moved);
    return rest.map((one, axis) => one + numberAt(moved, axis)) as Vector;
  }
  if (bone.convention === "fixed" && above) return rest.map((one) => one * scale) as Vector;
  return rest;
}

function rotation(bone: Bone, value: (channel: string) => number | null, radians: number): Quaternion {
  const listed = bone.channels
    .filter((channel) => channel[0] === "R")
    .map((channel) => itemAt(channel, 1).toUpperCase())
    .join("");
  const order =
    bone.convention === "listed"
      ? listed
      : [...bone.rotation_order.toUpperCase()].filter((axis) => listed.includes(axis)).join("");
  if (!order || bone.convention === "marker") return IDENTITY;
  const angles = [...order].map((axis) => (value(`R${axis.toLowerCase()}`) ?? 0) * radians);
  if (bone.convention === "listed") return turning(order, angles);
  const local = bone.convention === "fixed" ? fixed(order, angles) : turning(order, angles);
  const axes = bone.axes as Quaternion;
  return multiply(multiply(axes, local), inverse(axes));
}

/** A rotation's quaternion for a bone's channels, for views of channels as quaternions. */
export const localRotation = rotation;
