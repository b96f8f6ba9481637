/** Cards in rows of a virtual list. Arrows go from card to card, a click opens, Ctrl and Shift pick. */
import { useEffect, useRef, useState } from "preact/hooks";
import * as library from "../../state/library/library";
import { go } from "../../state/session/route";
import { VirtualList } from "../../ui/VirtualList";
import { w } from "../../words";
import { CardView } from "./CardView";

const CARD = 196; // least width
const TALL = 214;
const GAP = 14;
const RUNNING = 12; // cards that move by themselves

export function CardGrid() {
  const box = useRef<HTMLDivElement>(null);
  const [wide, setWide] = useState(0);
  const [first, setFirst] = useState(0);
  const [focus, setFocus] = useState(0);
  useEffect(() => {
    const observer = new ResizeObserver(([entry]) => entry && setWide(entry.contentRect.width));
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, []);
  void library.version.value;
  const total = library.total.value ?? 24;
  const columns = Math.max(1, Math.floor((wide - 2 * 16 + GAP) / (CARD + GAP)));
  const rows = Math.ceil(total / columns);

  const onKey = (event: KeyboardEvent) => {
    const step = {
      ArrowLeft: -1,
      ArrowRight: 1,
      ArrowUp: -columns,
      ArrowDown: columns,
      Home: -focus,
      End: total - 1 - focus,
    }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const next = Math.max(0, Math.min(total - 1, focus + step));
    setFocus(next);
    const card = library.cardAt(next);
    if (card) library.current.value = card.id;
    requestAnimationFrame(() => box.current?.querySelector<HTMLElement>(`[data-row="${next}"]`)?.focus());
  };
  return (
    <div ref={box} class="card-grid" onKeyDown={onKey}>
      {wide > 0 && (
        <VirtualList
          rows={rows}
          height={TALL + GAP}
          label={w("label.library")}
          role="grid"
          at={Math.floor(focus / columns)}
          onSeen={(from, to) => {
            setFirst(Math.max(0, from) * columns);
            library.look(from * columns, Math.min(total - 1, (to + 1) * columns - 1));
          }}
          render={(row) => (
            <div class="card-row" role="row" aria-rowindex={row + 1} style={{ gap: `${GAP}px`, padding: "8px 16px 0" }}>
              {Array.from({ length: Math.min(columns, total - row * columns) }, (_, column) => {
                const index = row * columns + column;
                return (
                  <CardView
                    key={index}
                    row={index}
                    card={library.cardAt(index)}
                    runs={index >= first && index < first + RUNNING + columns}
                    tabIndex={index === focus ? 0 : -1}
                    onFocus={() => {
                      setFocus(index);
                    }}
                    onOpen={(card) => go(`/clips/${card.id}`)}
                  />
                );
              })}
            </div>
          )}
        />
      )}
    </div>
  );
}
