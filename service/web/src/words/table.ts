/** Words of one panel, loaded with it: `const p = wordsOf(en, ko, ja)`, then `p("title", { n: 3 })`. */
import { language } from "../state/session/settings";
import { filled } from ".";

export function wordsOf<T extends Record<string, string>>(
  en: T,
  ko: { [K in keyof T]: string },
  ja: { [K in keyof T]: string },
) {
  const tables = { en, ko, ja };
  const word = (name: keyof T, values: Record<string, string | number> = {}): string =>
    filled(tables[language.value][name], values);
  return Object.assign(word, tables);
}
