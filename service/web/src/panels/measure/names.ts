/** Names of measurements as people read them. */
import { itemAt } from "../../lists";
import { JOINT_KINDS, type Kind } from "../../motion/body/quantities";
import { angleText, capital, jointText } from "../../ui/bodies/bodyNames";
import { AXIS_WORDS, KIND_WORDS } from "../../ui/clips/MeasurementChoice";
import { number, w, type Word } from "../../words";
import { m } from "./words";

/** A joint, the side of a foot, or an axis. */
const placeName = (name: string): string => {
  const axis = AXIS_WORDS[name];
  if (axis) return w(axis).toLowerCase();
  return SIDES[name] ? sideName(name).toLowerCase() : jointText(name);
};

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

/** "Speed: left hand" of "speed:left_hand"; an angle says its name alone. */
export function quantityName(quantity: string): string {
  const colon = quantity.indexOf(":");
  const kind = colon < 0 ? quantity : quantity.slice(0, colon);
  const parts = colon < 0 ? [] : quantity.slice(colon + 1).split(",");
  if (kind === "angle" && parts.length === 1) return capital(angleText(itemAt(parts, 0)));
  const isOfJoints = JOINT_KINDS.has(kind as Kind) || kind === "position";
  const named = isOfJoints ? parts.map(placeName) : parts;
  const what = named.join(", ");
  if (kind === "quantity" && what) return what;
  const word = KIND_WORDS[kind as Kind] as Word | undefined;
  const kindName = word ? w(word) : kind;
  return what ? m("label.quantityOf", { kind: kindName, what }) : kindName;
}
