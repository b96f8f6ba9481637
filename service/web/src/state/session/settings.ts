/** What a person set once for this browser: theme, language, sides, frame or time. Kept in localStorage. */
import { effect, signal, type Signal } from "@preact/signals";

/** A signal that is kept across visits. A browser without storage keeps it for the page. */
export function kept<T>(name: string, initial: T): Signal<T> {
  const key = `mcml.${name}`;
  let first = initial;
  try {
    const found = localStorage.getItem(key);
    if (found !== null) first = JSON.parse(found) as T;
  } catch {
    /* Private windows refuse storage. */
  }
  const value = signal(first);
  effect(() => {
    const text = JSON.stringify(value.value);
    try {
      localStorage.setItem(key, text);
    } catch {
      /* The same. */
    }
  });
  return value;
}

export type Theme = "dark" | "light" | "system";
/** The languages of the words, each by its own name and the mark of its button. */
export const LANGUAGES = {
  en: { name: "English", mark: "EN" },
  ko: { name: "한국어", mark: "한" },
  ja: { name: "日本語", mark: "日" },
} as const;
export type Language = keyof typeof LANGUAGES;
export const languages = Object.keys(LANGUAGES) as Language[];

export const theme = kept<Theme>("theme", "system");
export const language = kept<Language>(
  "language",
  languages.find((known) => navigator.language.startsWith(known)) ?? "en",
);
export const railWide = kept("rail", false);
export const singleKeys = kept("singleKeys", true);
export const swapSides = kept("swapSides", false);
export const timeAs = kept<"frame" | "seconds" | "timecode">("timeAs", "frame");

const dark = matchMedia("(prefers-color-scheme: dark)");
const systemDark = signal(dark.matches);
dark.addEventListener("change", () => (systemDark.value = dark.matches));

export const isDark = () => (theme.value === "system" ? systemDark.value : theme.value === "dark");
/** Moves with each change of what colours mean, so that canvases draw again. */
export const look = signal(0);

export const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");

export function followSettings(): void {
  effect(() => {
    const root = document.documentElement;
    root.dataset.theme = isDark() ? "dark" : "light";
    root.lang = language.value;
    if (swapSides.value) {
      const styles = getComputedStyle(root);
      const [left, right] = [styles.getPropertyValue("--left"), styles.getPropertyValue("--right")];
      root.style.setProperty("--left", right);
      root.style.setProperty("--right", left);
    } else {
      root.style.removeProperty("--left");
      root.style.removeProperty("--right");
    }
    look.value = look.peek() + 1;
  });
}

/** A colour token's value now, for canvases. */
export function colour(token: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${token}`).trim();
}
