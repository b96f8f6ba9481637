/** What is known of a clip's body, in words. */
import type { Schemas } from "../../api/client";
import type { Word } from "../../words";
import { rounded } from "./quantities";

type Value = Schemas["CalibrationValue"];

export const FACTS = {
  unit: "label.unit",
  up: "label.up",
  floor: "label.floor",
  leg: "label.legLength",
} as const satisfies Record<string, Word>;
export type Fact = keyof typeof FACTS;
export const ORIGINS: Record<Value["origin"], Word> = {
  stated: "label.originStated",
  measured: "label.originMeasured",
  guessed: "label.originGuessed",
  set: "label.originSet",
  unknown: "label.unknown",
};

/** "" where it is not known. */
export const shownValue = (one: Value): string =>
  typeof one.value === "number" ? String(rounded(one.value)) : String(one.value ?? "");
