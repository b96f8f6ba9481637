/** Where one is: the address of the page is the state of the view. Pages push an entry, moves in time replace it. */
import { computed, signal } from "@preact/signals";

/** Where a page is. */
export interface PageAddress {
  name: string;
  /** Such as "/clips". */
  path: string;
  /** What the second part of an address names: nothing, a section of the page or none, a thing or none, always a thing. */
  about: "nothing" | "section" | "any" | "one";
}

export interface Route {
  /** The name of the page; "unknown" where there is none. */
  page: string;
  /** What the page is about: a document, a result, an analysis; "" where none is named. */
  id: string;
  params: URLSearchParams;
}

const READ_AT_MOST_EVERY = 250; // ms; four replaced entries a second

let pages: readonly PageAddress[] = [];

/** The page of an address, with what it is about. "/" is the first page. */
export function pageOf(path: string, among: readonly PageAddress[] = pages): { page: string; id: string } {
  const unknown = { page: "unknown", id: "" };
  const [first = "", second = "", ...more] = path.split("/").slice(1);
  const found = first ? among.find((one) => one.path === `/${first}`) : among[0];
  if (!found || more.some(Boolean)) return unknown;
  let id: string;
  try {
    id = decodeURIComponent(second);
  } catch {
    return unknown;
  }
  if (found.about === (id ? "nothing" : "one")) return unknown;
  return { page: found.name, id };
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

/** Find pages among these, for as long as the application lives. */
export function followHistory(among: readonly PageAddress[]): void {
  pages = among;
  route.value = parsed();
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
