/** The colour of a motion name: the same in every clip, or what the project of the open one agreed on. */
import { signal } from "@preact/signals";

export const NAME_COLOURS = 8;

/** Colours of the project whose clip is open, by name. */
export const agreedColours = signal<ReadonlyMap<string, number>>(new Map());

/** Of a name's text: one of the eight, the same everywhere without being stored. */
export function nameColour(name: string): string {
  const agreed = agreedColours.value.get(name);
  if (agreed !== undefined) return `var(--name${agreed})`;
  let sum = 0;
  for (const letter of name) sum = (sum * 31 + letter.codePointAt(0)!) >>> 0;
  return `var(--name${sum % NAME_COLOURS})`;
}
