/** Fold the report as soon as something else of the page is used, so that it covers nothing. */
import { useEffect } from "preact/hooks";
import type { RefObject } from "preact";
import { trayOpen } from "../../../state/importing/uploads";

export function useFold(box: RefObject<HTMLElement | null>): void {
  useEffect(() => {
    const isElsewhere = (target: Element | null) =>
      target !== null && target.isConnected && !box.current?.contains(target) && !target.closest(".toasts, dialog");
    // After the click has done its work: the page must not move under a button that is being pressed.
    const click = (event: MouseEvent) => {
      if (trayOpen.peek() && isElsewhere(event.target as Element)) setTimeout(() => (trayOpen.value = false));
    };
    const tab = (event: KeyboardEvent) => {
      if (event.key === "Tab" && trayOpen.peek() && isElsewhere(document.activeElement)) trayOpen.value = false;
    };
    const escape = (event: KeyboardEvent) => {
      if (event.key !== "Escape" || !trayOpen.peek() || !box.current?.contains(document.activeElement)) return;
      event.stopPropagation();
      trayOpen.value = false;
      box.current.querySelector<HTMLElement>("header [aria-expanded]")?.focus();
    };
    document.addEventListener("click", click, true);
    document.addEventListener("keyup", tab);
    document.addEventListener("keydown", escape, true);
    return () => {
      document.removeEventListener("click", click, true);
      document.removeEventListener("keyup", tab);
      document.removeEventListener("keydown", escape, true);
    };
  }, [box]);
}
