/** A skeleton as the drawing code wants it: indices and typed arrays. */
import { entryOf, numberAt } from "../../lists";
import type { Schemas } from "../../api/client";

export type SkeletonView = Schemas["SkeletonView"];
export type Bone = SkeletonView["bones"][number];
export type Side = 0 | 1 | 2; // centre, left, right
export const SIDE_TOKENS = ["centre", "left", "right"] as const;

export interface Skeleton {
  view: SkeletonView;
  /** Joints, then tips: the points whose positions frames hold. */
  points: number;
  /** Pairs of points: bones, ends of chains, and lines between markers. */
  edges: Int32Array;
  sides: Uint8Array; // of points
  parents: Int32Array; // of points, -1 at roots
  /** Metres of one unit; where nobody can say, what makes a body 1.7 m tall. */
  metres: number;
  unitKnown: boolean;
  zUp: boolean;
  /** Height of the rest pose, metres. */
  height: number;
  head: number; // a point, -1 where nothing is called so
  byName: Map<string, number>;
}

/** Whether the name of a joint is one of MCML's that the server guessed. */
export const isGuess = (bone: Bone): boolean =>
  Boolean(bone.mapped) && bone.confidence !== null && bone.confidence !== undefined;

const SIDES: Record<string, Side> = { centre: 0, left: 1, right: 2 };
const USUAL_HEIGHT = 1.7;
const LEAST = 0.01; // metres
const HUGE = 20;

export function skeletonOf(answer: SkeletonView): Skeleton {
  // Browsers keep answers of a revision for ever: those of an earlier release lack newer lists.
  const view: SkeletonView = Object.assign({ centres: [], lines: [], plates: [] }, answer);
  const joints = view.bones.length;
  const points = joints + view.tips.length;
  const parents = new Int32Array(points);
  const sides = new Uint8Array(points);
  const rest = new Float64Array(points * 3);
  view.bones.forEach((bone, index) => {
    parents[index] = bone.parent;
    sides[index] = entryOf(SIDES, bone.side);
    for (let axis = 0; axis < 3; axis++) {
      rest[index * 3 + axis] =
        numberAt(bone.offset, axis) + (bone.parent >= 0 ? numberAt(rest, bone.parent * 3 + axis) : 0);
    }
  });
  view.tips.forEach((tip, place) => {
    const index = joints + place;
    parents[index] = tip.bone;
    sides[index] = numberAt(sides, tip.bone);
    for (let axis = 0; axis < 3; axis++)
      rest[index * 3 + axis] = numberAt(rest, tip.bone * 3 + axis) + numberAt(tip.offset, axis);
  });
  const shapes = new Set(view.bones.flatMap((bone, index) => (bone.convention === "shape" ? [index] : [])));
  // Targets of inverse kinematics are no bones of the body: lines to them would cross it.
  const targets = new Set(view.bones.flatMap((bone, index) => (bone.role === "control" ? [index] : [])));
  const edges = bonesOf(
    [...parents],
    view.bones.map((bone) => bone.name),
  ).filter(([start, end]) => !shapes.has(end) && !targets.has(start) && !targets.has(end));
  for (const [start, end] of view.lines) edges.push([start, end]);
  let extent = 0;
  for (let axis = 0; axis < 3; axis++) {
    let [least, most] = [Infinity, -Infinity];
    for (let point = 0; point < points; point++) {
      least = Math.min(least, numberAt(rest, point * 3 + axis));
      most = Math.max(most, numberAt(rest, point * 3 + axis));
    }
    extent = Math.max(extent, most - least);
  }
  const metres = view.metres ?? (extent > 0 ? USUAL_HEIGHT / extent : 1);
  return {
    view,
    points,
    edges: Int32Array.from(edges.flat()),
    sides,
    parents,
    metres,
    unitKnown: Boolean(view.unit),
    zUp: view.likely_up.endsWith("Z"),
    height: view.markers ? USUAL_HEIGHT : drawnHeight(extent * metres),
    head: view.bones.findIndex((bone) => bone.name.toLowerCase() === "head"),
    byName: new Map(view.bones.map((bone, index) => [bone.name, index])),
  };
}

/**
 * Pairs of points that bones lead between. What lies above the root, such as a joint on the ground that carries the
 * body, has no bone to it.
 */
export const bonesOf = (parents: readonly number[], names: readonly string[]): [number, number][] =>
  parents.flatMap((parent, point): [number, number][] =>
    parent < 0 || names[point] === "Root" ? [] : [[parent, point]],
  );

/** The height, metres, that bones are drawn as thick for. extent: of the rest pose, metres. */
function drawnHeight(extent: number): number {
  // A rest pose without lengths shows no height: places of joints come with the motion.
  if (extent < LEAST) return USUAL_HEIGHT;
  // One joint far away makes no giant; a body of more than that is in another unit than its file states.
  return extent > HUGE ? extent : Math.min(3, Math.max(0.1, extent));
}

/** Points below a joint, itself included. Points stand after their parents. */
export function subtree(skeleton: Skeleton, joint: number): number[] {
  const inside = new Set([joint]);
  for (let point = 0; point < skeleton.points; point++)
    if (inside.has(numberAt(skeleton.parents, point))) inside.add(point);
  return [...inside];
}
