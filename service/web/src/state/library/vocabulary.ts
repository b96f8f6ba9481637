/**
 * Motion names: what the project of the open clip agreed on, those in use with their numbers, and the anatomical
 * vocabulary. Asked once, again after changes.
 */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../../api/client";
import { agreedColours } from "../../motion/timeline/colours";

export const inUse = signal<Schemas["MotionNameInUse"][]>([]);
export const anatomical = signal<string[]>([]);
export const agreed = signal<Schemas["VocabularyWord"][]>([]);
let asked = false;
let followed: string | null = null;

/** Offer what a project agreed on, in its colours; null: nothing of any. */
export async function followProject(project: string | null): Promise<void> {
  followed = project;
  let found: Schemas["VocabularyWord"][] = [];
  if (project !== null) found = (await get("/vocabulary", { query: { project } }).catch(() => ({ items: [] }))).items;
  if (followed !== project) return;
  agreed.value = found;
  agreedColours.value = new Map(
    found.flatMap((word) =>
      word.colour === null || word.colour === undefined ? [] : [[word.name, word.colour] as const],
    ),
  );
}

export async function loadVocabulary(again = false): Promise<void> {
  if (asked && !again) return;
  asked = true;
  try {
    const answer = await get("/motion-names", {});
    inUse.value = answer.items;
    anatomical.value = answer.vocabulary.flatMap((part) =>
      (part.sided ? ["left-", "right-"] : [""]).flatMap((side) =>
        part.movements.map((movement) => `${side}${part.part}-${movement}`),
      ),
    );
  } catch {
    asked = false;
  }
}

/** Names that hold every word of a text: those agreed on first, then those in use. */
export function namesLike(text: string, most = 12): string[] {
  const words = text
    .toLowerCase()
    .split(/[\s-]+/)
    .filter(Boolean);
  const fits = (name: string) => words.every((word) => name.toLowerCase().includes(word));
  const used = inUse.value.map((one) => one.name).filter(fits);
  return [
    ...new Set([...agreed.value.map((one) => one.name).filter(fits), ...used, ...anatomical.value.filter(fits)]),
  ].slice(0, most);
}
