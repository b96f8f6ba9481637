/** Curves before and after an edit: which can be chosen, and the points to draw. Pure functions. */
import { itemAt } from "../../lists";
import type { Schemas } from "../../api/client";

export type CurveSamples = Schemas["CurveSamples"];
type Bone = Schemas["SkeletonView"]["bones"][number];

/** A curve as the service names it: a channel (BONE.CHANNEL) or a quantity of the body. */
export interface CurveName {
  kind: "column" | "quantity";
  name: string;
}
export interface Points {
  frames: number[];
  values: (number | null)[];
}

/** Frames and values of a reduced curve: of ranges of several frames the least value, then the greatest. shift: frames that
 * were deleted before the first. */
export function pointsOf({ first, step, minimum, maximum }: CurveSamples, shift = 0): Points {
  const start = first + shift;
  if (step === 1) return { frames: minimum.map((_, at) => start + at), values: minimum };
  return {
    frames: minimum.flatMap((_, at) => [start + at * step, start + at * step + step / 2]),
    values: minimum.flatMap((least, at) => [least, itemAt(maximum, at)]),
  };
}

export const keyOf = ({ kind, name }: CurveName): string => `${kind}=${name}`;

export function nameOf(key: string): CurveName {
  const at = key.indexOf("=");
  return { kind: key.slice(0, at) === "quantity" ? "quantity" : "column", name: key.slice(at + 1) };
}

/** The curves of a joint or marker: its channels, then its height and speed. */
export function curvesOfBone(bone: Bone): CurveName[] {
  const channels = bone.channels.map((channel): CurveName => ({ kind: "column", name: `${bone.name}.${channel}` }));
  // A comma separates the arguments of a quantity.
  if (bone.name.includes(",")) return channels;
  const quantities = ["height", "speed"].map((one): CurveName => ({ kind: "quantity", name: `${one}:${bone.name}` }));
  return [...channels, ...quantities];
}

/** The curve to show first: of the first of these joints that has channels, a rotation if it has one; else the first channel. */
export function startCurve(bones: readonly Bone[], wanted: readonly string[]): CurveName | null {
  const found = wanted.flatMap((name) => bones.filter((bone) => bone.name === name && bone.channels.length > 0))[0];
  const bone = found ?? bones.find((one) => one.channels.length > 0);
  const channel = found?.channels.find((one) => one.startsWith("R")) ?? bone?.channels[0];
  return bone && channel ? { kind: "column", name: `${bone.name}.${channel}` } : null;
}

/** Frame ranges with new samples of the joint or marker of a channel. */
export function replacedRanges(
  replaced: readonly Schemas["ReplacedSamples"][],
  { kind, name }: CurveName,
): readonly Schemas["FrameRange"][] {
  if (kind !== "column") return [];
  return replaced.find((one) => one.bone === name.slice(0, name.lastIndexOf(".")))?.ranges ?? [];
}
