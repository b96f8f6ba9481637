/** The list of documents under the filter that the address names: pages of it are fetched as they are looked at. */
import { itemAt } from "../../lists";
import { batch, computed, effect, signal } from "@preact/signals";
import { ask, get, type Schemas } from "../../api/client";
import { fromBase64, readThumbnail, type Thumbnail } from "../../motion/loading/thumbnail";
import { w } from "../../words";
import { news } from "../session/events";
import { note, refuse } from "../session/notes";
import { param, route } from "../session/route";
import { asOrder, asSort } from "./sorting";

export type Summary = Schemas["Card"];
export interface Card extends Omit<Summary, "labels" | "passport" | "thumbnail"> {
  thumb: Thumbnail | null;
  labels: NonNullable<Summary["labels"]>;
  passport: Summary["passport"];
}

export const FILTERS = [
  "project",
  "q",
  "motion_name",
  "format",
  "skeleton",
  "property",
  "length",
  "rate",
  "xpath",
  "collection",
] as const;
export type FilterName = (typeof FILTERS)[number];
const PAGE = 60;
const KEPT_PAGES = 60;
const WAIT = 120; // ms: a scroll that passes by asks for nothing

export const filter = computed<Record<string, string | string[]>>(() => {
  const { params } = route.value;
  const found: Record<string, string | string[]> = {};
  for (const name of FILTERS) {
    const values = params.getAll(name);
    if (values.length) found[name] = name === "property" ? values : itemAt(values, 0);
  }
  return found;
});
export const order = computed(() => asOrder(param("sort")));
const sort = computed(() => asSort(order.value));
const key = computed(() => JSON.stringify([filter.value, sort.value]));

export const total = signal<number | null>(null);
export const trouble = signal<unknown>(null);
/** Moves with each page that came. */
export const version = signal(0);
export const picked = signal<ReadonlySet<string>>(new Set());
/** The card that is looked at. */
export const current = signal<string | null>(null);

const pages = new Map<number, Card[]>();
const asked = new Map<number, AbortController>();
const cards = new Map<string, Card>();
/** Pages whose rows may have changed since. */
const old = new Set<number>();

export function cardAt(row: number): Card | null {
  return pages.get(Math.floor(row / PAGE))?.[row % PAGE] ?? null;
}

export const cardOf = (id: string): Card | null => cards.get(id) ?? null;

let seen: [number, number] = [0, PAGE - 1];
let timer = 0;

/** Rows that are in sight: their pages are fetched, others that are still awaited are not. */
export function look(first: number, last: number): void {
  seen = [first, last];
  window.clearTimeout(timer);
  timer = window.setTimeout(fetchSeen, pages.size ? WAIT : 0);
}

function fetchSeen(): void {
  const wanted = new Set<number>();
  for (let page = Math.floor(seen[0] / PAGE); page <= Math.floor(seen[1] / PAGE); page++) wanted.add(page);
  for (const [page, stop] of asked) {
    if (wanted.has(page)) continue;
    stop.abort();
    asked.delete(page);
  }
  for (const page of wanted) if ((!pages.has(page) || old.has(page)) && !asked.has(page)) void fetchPage(page);
}

async function fetchPage(page: number): Promise<void> {
  const stop = new AbortController();
  asked.set(page, stop);
  const asking = key.peek();
  try {
    const query = {
      ...filter.peek(),
      sort: sort.peek(),
      limit: PAGE,
      offset: page * PAGE,
      with: "thumbnail,labels,passport",
    };
    const answer = await get("/documents", { query, signal: stop.signal });
    if (asking !== key.peek()) return;
    const items = answer.items.map(asCard);
    for (const card of items) cards.set(card.id, card);
    pages.delete(page);
    pages.set(page, items);
    old.delete(page);
    if (pages.size > KEPT_PAGES) {
      const [oldest = page] = pages.keys();
      for (const card of pages.get(oldest) ?? []) if (!picked.peek().has(card.id)) cards.delete(card.id);
      pages.delete(oldest);
      old.delete(oldest);
    }
    batch(() => {
      total.value = answer.total ?? items.length;
      trouble.value = null;
      version.value++;
    });
    if (page === 0) performance.mark("first-cards");
  } catch (error) {
    if ((error as Error).name !== "AbortError" && asking === key.peek()) trouble.value = error;
  } finally {
    if (asked.get(page) === stop) asked.delete(page);
  }
}

function asCard(item: Summary): Card {
  let thumb: Thumbnail | null = null;
  try {
    thumb = item.thumbnail ? readThumbnail(fromBase64(item.thumbnail)) : null;
  } catch {
    /* A card without a picture is still a card. */
  }
  return { ...item, thumb, labels: item.labels ?? [], passport: item.passport };
}

/** Ask for everything anew, as after an import. What was there stays until the answer comes, so that a click meets its card. */
export function refresh(): void {
  for (const stop of asked.values()) stop.abort();
  asked.clear();
  for (const page of pages.keys()) old.add(page);
  fetchSeen();
}

let before = "";
effect(() => {
  const now = key.value;
  if (route.value.page !== "library") return;
  if (before && now !== before) {
    seen = [0, PAGE - 1];
    total.value = null;
    pages.clear();
    refresh();
  }
  before = now;
});

// What others store, change and delete is seen; a burst of it is asked for once.
let burst = 0;
effect(() => {
  if (!news.value || route.peek().page !== "library") return;
  window.clearTimeout(burst);
  burst = window.setTimeout(refresh, 400);
});

export function pick(id: string, on = !picked.peek().has(id)): void {
  const next = new Set(picked.peek());
  if (on) next.add(id);
  else next.delete(id);
  picked.value = next;
}

const IDS_AT_ONCE = 500;

/** Pick the rows from one to another, both included; those that were never in sight too. */
export async function pickRows(first: number, last: number): Promise<void> {
  const asking = key.peek();
  const ids: string[] = [];
  try {
    for (let offset = first; offset <= last; offset += IDS_AT_ONCE) {
      const limit = Math.min(IDS_AT_ONCE, last - offset + 1);
      const answer = await get("/documents", { query: { ...filter.peek(), sort: sort.peek(), limit, offset } });
      ids.push(...answer.items.map((one) => one.id));
    }
  } catch (error) {
    refuse(error);
    return;
  }
  // Another list is shown by now.
  if (asking === key.peek()) picked.value = new Set([...picked.peek(), ...ids]);
}

/** Hide documents; the toast brings them back. */
export async function removeDocuments(ids: string[]): Promise<void> {
  const gone: string[] = [];
  for (const id of ids) {
    try {
      const match = cardOf(id)?.revision ?? (await get("/documents/{id}", { path: { id } })).revision;
      await ask("delete", "/documents/{id}", { path: { id }, match });
      gone.push(id);
    } catch (error) {
      refuse(error);
    }
  }
  picked.value = new Set([...picked.peek()].filter((id) => !gone.includes(id)));
  refresh();
  if (gone.length)
    note(w("label.deleted", { n: gone.length }), { action: { text: w("button.undo"), run: () => void restore(gone) } });
}

async function restore(ids: string[]): Promise<void> {
  for (const id of ids) {
    try {
      const hidden = await get("/documents", { query: { id, deleted: true, limit: 1 } });
      await ask("post", "/documents/{id}/restore", { path: { id }, match: hidden.items[0]?.revision });
    } catch (error) {
      refuse(error);
    }
  }
  refresh();
  note(w("label.restored"));
}
