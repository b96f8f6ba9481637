/** Names of measurements as people read them. */
import type { Kind } from "../../motion/body/quantities";
import { KIND_WORDS } from "../../ui/clips/MeasurementChoice";
import { number, w, type Word } from "../../words";

const MOST_DECIMALS = 6;
const SIDES: Partial<Record<string, Word>> = { left: "label.sideLeft", right: "label.sideRight" };

export const sideName = (side: string): string => {
  const word = SIDES[side];
  return word ? w(word) : side;
};

/** A unit as the studio writes it. */
export const unitName = (unit: string): string => (unit === "deg" ? "°" : unit);

const DIGITS = 4;
/** A number with four digits; "–" where there is none. */
export const figure = (value: number | null, digits = DIGITS): string =>
  value === null ? "–" : number(Number(value.toPrecision(digits)), MOST_DECIMALS);

/** "Speed left_hand" of "speed:left_hand"; an angle says its name alone. */
export function quantityName(quantity: string): string {
  const colon = quantity.indexOf(":");
  const kind = colon < 0 ? quantity : quantity.slice(0, colon);
  const argument = colon < 0 ? "" : quantity.slice(colon + 1).replaceAll(",", ", ");
  if ((kind === "angle" || kind === "quantity") && argument) return argument;
  const word = KIND_WORDS[kind as Kind] as Word | undefined;
  return [word ? w(word) : kind, argument].filter(Boolean).join(" ");
}
