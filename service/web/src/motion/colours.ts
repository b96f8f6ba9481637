/** The colour of a motion name: the same in every clip. */
export const NAME_COLOURS = 8;

/** Of a name's text: one of the eight, the same everywhere without being stored. */
export function nameColour(name: string): string {
  let sum = 0;
  for (const letter of name) sum = (sum * 31 + letter.codePointAt(0)!) >>> 0;
  return `var(--name${sum % NAME_COLOURS})`;
}
