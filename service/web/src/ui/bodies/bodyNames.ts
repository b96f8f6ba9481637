/** Names of joints and activities as people say them. */
import { b, type BodyWord } from "./words";

const PARTS = new Set([
  "hand",
  "low_arm",
  "up_arm",
  "shoulder",
  "up_leg",
  "low_leg",
  "foot",
  "toes",
  "Head",
  "Root",
  "neck1",
  "waist",
]);
export const ACTIVITIES = [
  "walk",
  "run",
  "step",
  "jump",
  "stand",
  "sit",
  "crouch",
  "lie",
  "turn",
  "turn left",
  "turn right",
  "kick",
  "left kick",
  "right kick",
  "wave",
  "left wave",
  "right wave",
  "reach",
  "left reach",
  "right reach",
  "raise hand",
  "raise left hand",
  "raise right hand",
] as const;

const partText = (part: string): string => (PARTS.has(part) ? b(`label.part_${part}` as BodyWord) : part);

/** "left hand" of left_hand; names that MCML has not stay as they are. */
export function jointText(name: string): string {
  const [side, part] = [name.slice(0, name.indexOf("_")), name.slice(name.indexOf("_") + 1)];
  if ((side === "left" || side === "right") && PARTS.has(part))
    return b(side === "left" ? "label.leftOf" : "label.rightOf", { part: partText(part) });
  return partText(name);
}

/** "left knee flexion" of left-knee-flexion; movements that have no word stay as they are. */
export function angleText(name: string): string {
  const [, side = "", body = "", movement = ""] = /^(?:(left|right)-)?([a-z]+)-(.+)$/.exec(name) ?? [];
  const words = { part: `label.body_${body}`, movement: `label.move_${movement}` };
  if (!(words.part in b.en && words.movement in b.en)) return name.replaceAll("-", " ");
  const part = b(words.part as BodyWord);
  return b("label.angleOf", {
    part: side ? b(side === "left" ? "label.leftOf" : "label.rightOf", { part }) : part,
    movement: b(words.movement as BodyWord),
  });
}

export const activityText = (name: string): string =>
  (ACTIVITIES as readonly string[]).includes(name)
    ? b(`label.activity_${name.replaceAll(" ", "_")}` as BodyWord)
    : name;

/** A sentence with a capital letter. */
export const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);
