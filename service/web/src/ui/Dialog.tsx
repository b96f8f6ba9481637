/** A dialog above the page: the browser's own element traps the focus and closes by Esc. */
import { useEffect, useRef } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { w } from "../words";
import { Icon } from "./icons";

export function Dialog({
  title,
  onClose,
  children,
  wide = false,
}: {
  title: string;
  onClose: () => void;
  children: ComponentChildren;
  wide?: boolean;
}) {
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    box.current?.showModal();
    return () => before?.focus?.();
  }, []);
  return (
    <dialog
      ref={box}
      class={wide ? "wide" : ""}
      aria-label={title}
      onClose={onClose}
      onClick={(event) => event.target === box.current && box.current?.close()}
    >
      <header class="row">
        <h2 class="grow">{title}</h2>
        <button
          type="button"
          class="button quiet icon"
          aria-label={w("button.close")}
          onClick={() => box.current?.close()}
        >
          <Icon name="close" />
        </button>
      </header>
      {children}
    </dialog>
  );
}
