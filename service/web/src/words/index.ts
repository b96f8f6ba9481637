/** Words in the language of the page. All tables have the same keys by type: one that misses fails the build. */
import { type Language, language } from "../state/session/settings";
import { en } from "./en";
import { ja } from "./ja";
import { ko } from "./ko";

export type Words = typeof en;
export type Word = keyof Words;

const TABLES: Record<Language, Words> = { en, ko, ja };

/** A sentence with its values. "one|many" chooses by `n`. */
export const w = (word: Word, values: Record<string, string | number> = {}): string =>
  filled(TABLES[language.value][word], values);

/** A sentence of any table with its values. */
export function filled(sentence: string, values: Record<string, string | number>): string {
  const [one = "", many, ...more] = sentence.split("|");
  const form = many !== undefined && !more.length && values.n !== 1 ? many : one;
  return form.replace(/\{(\w+)\}/g, (_, name: string) => {
    const value = values[name];
    return typeof value === "number" ? number(value) : String(value ?? "");
  });
}

export const number = (value: number, digits?: number): string =>
  new Intl.NumberFormat(language.value, digits === undefined ? {} : { maximumFractionDigits: digits }).format(value);

/** Seconds as 4.2 s, or 2:04.5 from a minute on. */
export function duration(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined) return "–";
  const tenths = Math.round(seconds * 10);
  if (tenths < 600) return `${number(seconds, seconds < 10 ? 2 : 1)} s`;
  return `${Math.floor(tenths / 600)}:${((tenths % 600) / 10).toFixed(1).padStart(4, "0")}`;
}

export function rate(secondsPerFrame: number | null | undefined): string {
  return secondsPerFrame ? `${number(1 / secondsPerFrame, 2)} Hz` : w("label.rateUnknown");
}

export function when(iso: string): string {
  const then = new Date(iso);
  const minutes = (Date.now() - then.getTime()) / 60_000;
  const relative = new Intl.RelativeTimeFormat(language.value, { numeric: "auto", style: "short" });
  if (minutes < 1) return relative.format(0, "second");
  if (minutes < 60) return relative.format(-Math.round(minutes), "minute");
  if (minutes < 24 * 60) return relative.format(-Math.round(minutes / 60), "hour");
  if (minutes < 7 * 24 * 60) return relative.format(-Math.round(minutes / 60 / 24), "day");
  return then.toLocaleDateString(language.value);
}
