/** Words for names that come from results: attributes, units, reasons. */
import { b } from "./words";

type Name = keyof typeof b.en;

/** Whether the table has such a word. */
export const isWord = (name: string): name is Name => name in b.en;

const orItself = (word: string, name: string): string => (isWord(word) ? b(word) : name);

export const nameOf = (attribute: string): string => orItself(`label.name_${attribute}`, attribute);
export const unitOf = (unit: string): string => orItself(`label.unit_${unit}`, unit);
export const reasonOf = (code: string): string => orItself(`label.why_${code}`, code);
export const flagOf = (code: string): string => orItself(`label.flag_${code}`, code);
