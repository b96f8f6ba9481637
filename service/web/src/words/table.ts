/** Words of one panel, loaded with it: `const p = wordsOf(en, ko)`, then `p("title", { n: 3 })`. */
import { language } from "../state/session/settings";
import { filled } from ".";

export function wordsOf<T extends Record<string, string>>(en: T, ko: { [K in keyof T]: string }) {
  const word = (name: keyof T, values: Record<string, string | number> = {}): string =>
    filled((language.value === "ko" ? ko : en)[name], values);
  return Object.assign(word, { en, ko });
}
