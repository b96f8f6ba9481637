/** Words for names that come from results: attributes, units, reasons. */
import { b } from "./words";

type Name = keyof typeof b.en;

/** Whether the table has such a word. */
export const isWord = (name: string): name is Name => name in b.en;

const orItself = (kind: string, name: string): string => {
  const word = `${kind}_${name}`;
  return isWord(word) ? b(word) : name;
};

export const nameOf = (attribute: string): string => orItself("name", attribute);
export const unitOf = (unit: string): string => orItself("unit", unit);
export const reasonOf = (code: string): string => orItself("why", code);
export const flagOf = (code: string): string => orItself("flag", code);
