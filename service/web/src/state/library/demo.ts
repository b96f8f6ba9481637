/** The demo library, loaded into the repository part by part; and whether the repository has any clips. */
import { effect, signal } from "@preact/signals";
import { ask, get, type Schemas } from "../../api/client";
import { news } from "../session/events";
import { w } from "../../words";
import { refresh } from "./library";
import { loadVocabulary } from "./vocabulary";

export type DemoPart = Schemas["DemoPartLoaded"]["part"];

export const ALL_PARTS: readonly DemoPart[] = ["people", "walks", "dances", "faces", "reaches"];

/** Whether the repository has no clips that the visitor sees; null until it is known. */
export const isEmpty = signal<boolean | null>(null);

export async function askWhetherEmpty(): Promise<void> {
  try {
    isEmpty.value = !(await get("/documents", { query: { limit: 1 } })).items.length;
  } catch {
    // The page then shows its usual form, which says what is wrong.
    isEmpty.value = false;
  }
}

effect(() => {
  if (news.value && isEmpty.peek()) void askWhetherEmpty();
});

/** Parts of the demo library that are stored, of those being loaded; null while none are loaded. */
export const demoProgress = signal<{ done: number; all: number } | null>(null);

/** Store parts of the demo library; clips that are stored already are skipped. */
export async function loadDemo(parts: readonly DemoPart[]): Promise<void> {
  try {
    for (const [done, part] of parts.entries()) {
      demoProgress.value = { done, all: parts.length };
      await ask("post", "/demo", { query: { part: [part] } });
    }
  } finally {
    demoProgress.value = null;
    refresh();
    await Promise.all([loadVocabulary(true), askWhetherEmpty()]);
  }
}

/** Clips of the demo library by name. Error where one was renamed or deleted. */
export async function demoClips(...names: string[]): Promise<{ id: string; name: string }[]> {
  const { items } = await get("/documents", { query: { project: "demo", limit: 100, sort: "name" } });
  return names.map((name) => {
    const found = items.find((one) => one.name === name);
    if (!found) throw new Error(w("error.demoGone", { name }));
    return { id: found.id, name };
  });
}
