/** What is known of a clip's body, in words. */
import type { Schemas } from "../../api/client";
import type { Word } from "../../words";
import { rounded } from "./quantities";

type Value = Schemas["CalibrationValue"];

export const FACTS = { unit: "unit", up: "up", floor: "floor", leg: "legLength" } as const satisfies Record<
  string,
  Word
>;
export type Fact = keyof typeof FACTS;
export const ORIGINS: Record<Value["origin"], Word> = {
  stated: "originStated",
  measured: "originMeasured",
  guessed: "originGuessed",
  set: "originSet",
  unknown: "unknown",
};

/** "" where it is not known. */
export const shownValue = (one: Value): string =>
  typeof one.value === "number" ? String(rounded(one.value)) : String(one.value ?? "");
