/** What the repository says of a composition, and what of it a person should look at. */
import type { Schemas } from "../../api/client";
import type { Skeleton } from "../../motion/body/skeleton";

export type Composed = Schemas["Composed"] & { step: number; skeleton: Skeleton };
export type Seam = Schemas["ComposedSeam"];

const ROUGH = 1.5; // a step over a seam, in parts of the largest inside the pieces

export const stepOf = (seam: Seam): number => Math.max(seam.root_step, seam.angle_step);
export const isRough = (seam: Seam): boolean => stepOf(seam) > ROUGH;
/** How far a piece was moved on the ground, in the unit of the clip. */
export const shiftOf = (seam: Seam): number => Math.hypot(...seam.shift);
