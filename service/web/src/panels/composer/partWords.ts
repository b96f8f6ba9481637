import type { Part } from "../../motion/body/parts";
import type { Word } from "../../words";

export const PART_WORDS = {
  upper: "label.partUpper",
  arms: "label.partArms",
  leftArm: "label.partLeftArm",
  rightArm: "label.partRightArm",
  head: "label.partHead",
  legs: "label.partLegs",
} as const satisfies Record<Part, Word>;
