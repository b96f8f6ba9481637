import type { Part } from "../../motion/body/parts";
import type { Word } from "../../words";

export const PART_WORDS = {
  upper: "partUpper",
  arms: "partArms",
  leftArm: "partLeftArm",
  rightArm: "partRightArm",
  head: "partHead",
  legs: "partLegs",
} as const satisfies Record<Part, Word>;
