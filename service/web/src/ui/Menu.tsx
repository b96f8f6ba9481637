/** A button that opens a menu, after the ARIA pattern: arrows inside, Esc closes, the focus comes back. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { Icon, type IconName } from "./icons";

export interface Item {
  text: string;
  detail?: string;
  icon?: IconName;
  run?: () => void;
  /** Of a link: where it leads; `download` saves it. */
  href?: string;
  /** true: under the server's name. */
  download?: boolean | string;
  checked?: boolean;
  disabled?: boolean;
}

const EDGE = 8; // px between a menu and the edge of the window
const GAP = 4; // px between a menu and its button

/** Near the window's edge a menu moves inwards, at its lower edge above the button. */
function moveInwards(shown: HTMLElement, button: DOMRect): void {
  const { top, right, bottom, height } = shown.getBoundingClientRect();
  const x = Math.min(0, innerWidth - EDGE - right);
  const above = button.top - GAP - height;
  const y =
    bottom + EDGE <= innerHeight ? 0 : above >= EDGE ? above - top : Math.max(EDGE - top, innerHeight - EDGE - bottom);
  if (x || y) shown.style.transform = `translate(${x}px, ${y}px)`;
}

export function Menu({
  label,
  items,
  children,
  className = "button",
  side = "left",
}: {
  label: string;
  items: Item[] | (() => Item[]);
  children: ComponentChildren;
  className?: string;
  side?: "left" | "right";
}) {
  const [open, setOpen] = useState(false);
  const box = useRef<HTMLSpanElement>(null);
  const button = useRef<HTMLButtonElement>(null);

  useEffect(() => {
    if (!open) return;
    const shown = box.current?.querySelector<HTMLElement>(".menu-list");
    const around = button.current?.getBoundingClientRect();
    if (shown && around) moveInwards(shown, around);
    box.current?.querySelector<HTMLElement>("[role^=menuitem]:not([aria-disabled=true])")?.focus();
    const outside = (event: PointerEvent) => {
      if (!box.current?.contains(event.target as Node)) setOpen(false);
    };
    addEventListener("pointerdown", outside);
    return () => removeEventListener("pointerdown", outside);
  }, [open]);

  const close = () => {
    setOpen(false);
    button.current?.focus();
  };
  const onKey = (event: KeyboardEvent) => {
    if (!open) return;
    const all = [...(box.current?.querySelectorAll<HTMLElement>("[role^=menuitem]") ?? [])];
    const place = all.indexOf(document.activeElement as HTMLElement);
    const to = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: all.length - 1 }[event.key];
    if (event.key === "Escape") close();
    else if (event.key === "Tab") setOpen(false);
    else if (to !== undefined) all[(to + all.length) % all.length]?.focus();
    else return;
    if (event.key !== "Tab") event.preventDefault();
    event.stopPropagation();
  };
  const list = open ? (typeof items === "function" ? items() : items) : [];
  return (
    <span class="menu" ref={box} onKeyDown={onKey}>
      <button
        ref={button}
        type="button"
        class={className}
        aria-haspopup="menu"
        aria-expanded={open}
        title={label}
        onClick={() => setOpen(!open)}
      >
        <span class="unseen">{label}: </span>
        {children}
      </button>
      {open && (
        <div class={`menu-list ${side}`} role="menu" aria-label={label}>
          {list.map((item) => {
            const body = (
              <>
                <span class="menu-mark">
                  {item.checked ? <Icon name="check" /> : item.icon ? <Icon name={item.icon} /> : null}
                </span>
                <span class="grow">{item.text}</span>
                {item.detail && <span class="dim">{item.detail}</span>}
              </>
            );
            return item.href ? (
              <a
                key={item.text}
                role="menuitem"
                tabIndex={-1}
                href={item.href}
                download={item.download === true ? "" : item.download || undefined}
                onClick={close}
              >
                {body}
              </a>
            ) : (
              <button
                key={item.text}
                type="button"
                role={item.checked === undefined ? "menuitem" : "menuitemcheckbox"}
                aria-checked={item.checked}
                aria-disabled={item.disabled}
                tabIndex={-1}
                onClick={() => {
                  if (!item.disabled) {
                    close();
                    item.run?.();
                  }
                }}
              >
                {body}
              </button>
            );
          })}
        </div>
      )}
    </span>
  );
}
