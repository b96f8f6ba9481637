/** The body that clips are shown on: the own one, or a character of the library. It stays from clip to clip. */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../../api/client";
import { kept } from "../session/settings";

/** The document of the chosen character; "": the own body. */
export const chosenCharacter = kept("character", "");

/** The characters of the library, as far as they are known. */
export const characters = signal<readonly Schemas["CharacterInfo"][]>([]);

/** Ask for the characters of the library; visitors with a link have none. */
export async function loadCharacters(): Promise<void> {
  try {
    characters.value = (await get("/characters")).items;
  } catch {
    // The own body is there without them.
  }
}

/** The name of a character; null where the library has no such one. */
export const nameOfCharacter = (id: string): string | null =>
  characters.value.find((one) => one.document === id)?.name ?? null;
