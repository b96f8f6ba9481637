/** A group of items that is one Tab stop: arrows, Home and End go from item to item (ARIA Authoring Practices, roving tabindex). */
import { useLayoutEffect, useRef } from "preact/hooks";

const STEPS: Record<string, number> = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 };

/** The item that an arrow leads to; the first and the last have no neighbour beyond. */
export function nextItem(key: string, at: number, count: number): number | null {
  if (key === "Home") return 0;
  if (key === "End") return count - 1;
  const step = STEPS[key];
  return step === undefined ? null : Math.max(0, Math.min(count - 1, at + step));
}

const isShown = (item: HTMLElement): boolean =>
  item.tagName === "SUMMARY" || item.closest("details:not([open])") === null;

/** Properties of the element that holds the items. selector: finds the items in it. */
export function useRoving<T extends HTMLElement>(selector: string) {
  const box = useRef<T>(null);
  const last = useRef<HTMLElement | null>(null);
  const items = () => [...(box.current?.querySelectorAll<HTMLElement>(selector) ?? [])];
  const mark = () => {
    const all = items();
    const stop =
      all.find((one) => one === last.current) ??
      all.find((one) => one.ariaPressed === "true" && isShown(one)) ??
      all[0];
    for (const one of all) one.tabIndex = one === stop ? 0 : -1;
  };
  // Without dependencies: a new item has no place in the order yet.
  useLayoutEffect(mark);
  return {
    ref: box,
    onFocusIn: (event: FocusEvent) => {
      const found = items().find((one) => one === event.target);
      if (!found) return;
      last.current = found;
      mark();
    },
    onKeyDown: (event: KeyboardEvent) => {
      const all = items().filter(isShown);
      const at = all.findIndex((one) => one === event.target);
      const next = at < 0 ? null : nextItem(event.key, at, all.length);
      if (next === null) return;
      event.preventDefault();
      event.stopPropagation();
      all[next]?.focus();
    },
  };
}
