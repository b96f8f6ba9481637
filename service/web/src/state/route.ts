/** Where one is: the address of the page is the state of the view. Pages push an entry, moves in time replace it. */
import { computed, signal } from "@preact/signals";

export type Page =
  | "library"
  | "clip"
  | "xpath"
  | "compose"
  | "retarget"
  | "reach"
  | "dance"
  | "faces"
  | "analyses"
  | "results"
  | "settings"
  | "unknown";

export interface Route {
  page: Page;
  /** What the page is about: a document, a result, an analysis; "" where none is named. */
  id: string;
  params: URLSearchParams;
}

const READ_AT_MOST_EVERY = 250; // ms; four replaced entries a second

/** Pages by the first part of their addresses. */
const PAGES = new Map<string, Page>([
  ["", "library"],
  ["library", "library"],
  ["xpath", "xpath"],
  ["compose", "compose"],
  ["retarget", "retarget"],
  ["settings", "settings"],
  ["clips", "clip"],
  ["reach", "reach"],
  ["dance", "dance"],
  ["faces", "faces"],
  ["analyses", "analyses"],
  ["results", "results"],
]);
/** Those about one thing, which the second part names. */
const OF_ONE = new Set<Page>(["clip", "settings", "reach", "dance", "faces", "analyses", "results"]);

/** The page of an address, with what it is about. */
export function pageOf(path: string): { page: Page; id: string } {
  const [first = "", second = "", ...more] = path.split("/").slice(1);
  const page = PAGES.get(first);
  let id: string;
  try {
    id = decodeURIComponent(second);
  } catch {
    return { page: "unknown", id: "" };
  }
  if (!page || more.some(Boolean) || (page === "clip" && !id) || (id && !OF_ONE.has(page)))
    return { page: "unknown", id: "" };
  return { page, id };
}

const parsed = (): Route => ({ ...pageOf(location.pathname), params: new URLSearchParams(location.search) });

export const route = signal<Route>(parsed());
export const page = computed(() => route.value.page);

/** One parameter of the address; "" where it is not said. */
export const param = (name: string): string => route.value.params.get(name) ?? "";

export function go(path: string): void {
  flush();
  history.pushState(null, "", path);
  route.value = parsed();
}

const loaders = new Map<Page, () => Promise<unknown>>();

/** How a page's code is loaded: said by the shell, which knows the pages. */
export const loadedBy = (page: Page, load: () => Promise<unknown>): void => void loaders.set(page, load);

/** Load a page's code before it is opened; what fails is said when it is. */
export const prefetch = (page: Page): void =>
  void loaders
    .get(page)?.()
    .catch(() => undefined);

let waiting: Record<string, string | null> = {};
let timer = 0;

/** Write parameters into the address, at once in memory and soon in the bar. null takes one away. */
export function setParams(changes: Record<string, string | null>, push = false): void {
  if (push) {
    flush();
    history.pushState(null, "", location.href);
  }
  Object.assign(waiting, changes);
  const params = new URLSearchParams(route.peek().params);
  apply(params, changes);
  route.value = { ...route.peek(), params };
  if (push) flush();
  else if (!timer) timer = window.setTimeout(flush, READ_AT_MOST_EVERY);
}

/** As setParams, for what changes with time: the signal is not touched, so that nothing is drawn for it. */
export function noteParams(changes: Record<string, string | null>): void {
  Object.assign(waiting, changes);
  apply(route.peek().params, changes);
  if (!timer) timer = window.setTimeout(flush, READ_AT_MOST_EVERY);
}

function apply(params: URLSearchParams, changes: Record<string, string | null>): void {
  for (const [name, value] of Object.entries(changes)) {
    if (value === null || value === "") params.delete(name);
    else params.set(name, value);
  }
}

function flush(): void {
  window.clearTimeout(timer);
  timer = 0;
  if (!Object.keys(waiting).length) return;
  waiting = {};
  const text = route.peek().params.toString();
  history.replaceState(null, "", location.pathname + (text ? `?${text}` : ""));
}

export function followHistory(): void {
  addEventListener("popstate", () => {
    window.clearTimeout(timer);
    timer = 0;
    waiting = {};
    route.value = parsed();
  });
  // Links of this application load nothing anew.
  document.addEventListener("click", (event) => {
    const link = (event.target as Element).closest?.("a[href]") as HTMLAnchorElement | null;
    if (!link || event.defaultPrevented || event.button || event.metaKey || event.ctrlKey || event.shiftKey) return;
    // Within the page: the focus goes there, and the address stays that of the view.
    if (link.getAttribute("href")!.startsWith("#")) {
      event.preventDefault();
      document.getElementById(link.hash.slice(1))?.focus();
      return;
    }
    if (link.target || link.hasAttribute("download") || link.origin !== location.origin) return;
    if (/^\/(api|docs|mcml\.dtd|login|healthz|metrics)/.test(link.pathname)) return;
    event.preventDefault();
    go(link.pathname + link.search);
  });
}
