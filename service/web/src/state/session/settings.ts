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
export type Language = "en" | "ko";

export const theme = kept<Theme>("theme", "system");
export const language = kept<Language>("language", navigator.language.startsWith("ko") ? "ko" : "en");
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
