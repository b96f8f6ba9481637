/** Motion names: those in use with their numbers, and the anatomical vocabulary. Asked once, again after changes. */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../api/client";

export const inUse = signal<Schemas["MotionNameInUse"][]>([]);
export const anatomical = signal<string[]>([]);
let asked = false;

export async function loadVocabulary(again = false): Promise<void> {
  if (asked && !again) return;
  asked = true;
  try {
    const answer = await get("/motion-names", {});
    inUse.value = answer.items;
    anatomical.value = answer.vocabulary.flatMap((part) =>
      (part.sided ? ["left-", "right-"] : [""]).flatMap((side) => part.movements.map((movement) => `${side}${part.part}-${movement}`)),
    );
  } catch {
    asked = false;
  }
}

/** Names that hold every word of a text, those in use first. */
export function namesLike(text: string, most = 12): string[] {
  const words = text.toLowerCase().split(/[\s-]+/).filter(Boolean);
  const fits = (name: string) => words.every((word) => name.toLowerCase().includes(word));
  const used = inUse.value.map((one) => one.name).filter(fits);
  return [...new Set([...used, ...anatomical.value.filter(fits)])].slice(0, most);
}
