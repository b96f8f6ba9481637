/** Rows of one height of which only those in sight exist. Millions of rows are scaled into a height browsers can scroll. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren, JSX } from "preact";

const TALLEST = 8_000_000; // px; browsers stop at 16.7 to 33 million
const SPARE = 4; // rows above and below those in sight

export function VirtualList({
  rows,
  height,
  render,
  label,
  role = "list",
  at,
  onSeen,
  className = "",
  onKeyDown,
}: {
  rows: number;
  height: number;
  render: (row: number) => ComponentChildren;
  label: string;
  role?: "list" | "tree" | "grid" | "listbox" | "table";
  /** Scroll so that this row is seen, whenever it changes. */
  at?: number;
  onSeen?: (first: number, last: number) => void;
  className?: string;
  onKeyDown?: (event: KeyboardEvent) => void;
}) {
  const box = useRef<HTMLDivElement>(null);
  const [view, setView] = useState({ top: 0, size: 600 });
  const whole = rows * height;
  const drawn = Math.min(whole, TALLEST);
  const scale = whole > drawn ? (whole - view.size) / Math.max(1, drawn - view.size) : 1;
  const top = view.top * scale;
  const first = Math.max(0, Math.floor(top / height) - SPARE);
  const last = Math.min(rows - 1, Math.ceil((top + view.size) / height) + SPARE);

  useEffect(() => {
    const element = box.current!;
    const measure = () => setView({ top: element.scrollTop, size: element.clientHeight });
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    measure();
    return () => observer.disconnect();
  }, []);
  useEffect(() => onSeen?.(first, last), [first, last, rows]);
  useEffect(() => {
    const element = box.current!;
    if (at === undefined || at < 0) return;
    const y = at * height;
    if (y < top || y + height > top + view.size) {
      element.scrollTop = Math.max(0, y - view.size / 3) / scale;
    }
  }, [at]);

  const shift = view.top - top; // what scaling moves
  const shown: JSX.Element[] = [];
  for (let row = first; row <= last; row++) {
    shown.push(
      <div
        key={row}
        class="virtual-row"
        role="presentation"
        style={{ height: `${height}px`, transform: `translateY(${row * height + shift}px)` }}
      >
        {render(row)}
      </div>,
    );
  }
  return (
    <div
      ref={box}
      class={`virtual ${className}`}
      role={role}
      aria-label={label}
      tabIndex={-1}
      onKeyDown={onKeyDown}
      onScroll={(event) => {
        const element = event.currentTarget;
        setView({ top: element.scrollTop, size: element.clientHeight });
      }}
    >
      <div class="virtual-whole" role="presentation" style={{ height: `${drawn}px` }}>
        {shown}
      </div>
    </div>
  );
}
