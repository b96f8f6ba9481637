/** Tabs after the ARIA pattern: one stop, arrows inside. Those that do not fit are in a menu; the open one always fits. */
import { itemAt } from "../lists";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { w } from "../words";
import { Icon } from "./icons";
import { Menu } from "./Menu";

const MORE = 34; // px, of the menu's button
const GAP = 2;
const EDGES = 16;

export function Tabs({
  label,
  tabs,
  open,
  onOpen,
}: {
  label: string;
  tabs: { id: string; text: string }[];
  open: string;
  onOpen: (id: string) => void;
}) {
  const box = useRef<HTMLDivElement>(null);
  const widths = useRef<HTMLDivElement>(null);
  const moved = useRef(false);
  const [fit, setFit] = useState(tabs.length);
  const texts = tabs.map((tab) => tab.text).join("\n");
  useLayoutEffect(() => {
    const measure = () => {
      const each = [...(widths.current?.children ?? [])].map((one) => (one as HTMLElement).offsetWidth + GAP);
      const room = (box.current?.clientWidth ?? 0) - EDGES;
      if (room <= 0) return; // Not shown.
      const needed = (some: number[]) => some.reduce((sum, one) => sum + one, 0);
      if (needed(each) <= room) {
        setFit(each.length);
        return;
      }
      const widest = Math.max(...each); // The open one may stand in the last place.
      let count = each.length - 1;
      while (count > 1 && needed(each.slice(0, count - 1)) + widest + MORE > room) count--;
      setFit(count);
    };
    const watching = new ResizeObserver(measure);
    watching.observe(box.current!);
    measure();
    return () => watching.disconnect();
  }, [texts]);
  useEffect(() => {
    if (moved.current) box.current?.querySelector<HTMLElement>(`#tab-${open}`)?.focus();
    moved.current = false;
  }, [open]);
  const first = tabs.slice(0, fit);
  const current = tabs.find((tab) => tab.id === open);
  const shown = !current || first.includes(current) ? first : [...first.slice(0, -1), current];
  const rest = tabs.filter((tab) => !shown.includes(tab));
  return (
    <div class="tabs" ref={box}>
      <div class="tabs-widths" ref={widths} aria-hidden="true">
        {tabs.map((tab) => (
          <span key={tab.id}>{tab.text}</span>
        ))}
      </div>
      <div
        class="tabs-shown"
        role="tablist"
        aria-label={label}
        onKeyDown={(event) => {
          const at = tabs.findIndex((tab) => tab.id === open);
          const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: tabs.length - 1 }[event.key];
          if (to === undefined) return;
          moved.current = true;
          onOpen(itemAt(tabs, (to + tabs.length) % tabs.length).id);
          event.preventDefault();
          event.stopPropagation();
        }}
      >
        {shown.map((tab) => (
          <button
            key={tab.id}
            id={`tab-${tab.id}`}
            type="button"
            role="tab"
            aria-selected={tab.id === open}
            aria-controls={tab.id === open ? `panel-${tab.id}` : undefined}
            tabIndex={tab.id === open ? 0 : -1}
            onClick={() => onOpen(tab.id)}
          >
            {tab.text}
          </button>
        ))}
      </div>
      {rest.length > 0 && (
        <Menu
          label={w("label.more")}
          side="right"
          className="tabs-more"
          items={rest.map((tab) => ({
            text: tab.text,
            run: () => {
              moved.current = true;
              onOpen(tab.id);
            },
          }))}
        >
          <Icon name="more" />
        </Menu>
      )}
    </div>
  );
}
