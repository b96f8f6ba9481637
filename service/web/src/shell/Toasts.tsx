import { useEffect, useRef } from "preact/hooks";
import { dismiss, held, notes } from "../state/session/notes";
import { w } from "../words";
import { Icon } from "../ui/icons";

export function Toasts() {
  const box = useRef<HTMLDivElement>(null);
  // What floats at the bottom, as the list of uploads does, stands above them.
  useEffect(() => {
    const observer = new ResizeObserver(() =>
      document.documentElement.style.setProperty("--toasts", `${box.current?.offsetHeight ?? 0}px`),
    );
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, []);
  return (
    <div ref={box} class="toasts" role="region" aria-label={w("label.notices")} aria-live="polite">
      {notes.value.map((one) => (
        <div
          key={one.id}
          class={`toast ${one.bad ? "bad" : ""}`}
          role={one.bad ? "alert" : "status"}
          onPointerEnter={() => held.add(one.id)}
          onPointerLeave={() => held.delete(one.id)}
          onFocusIn={() => held.add(one.id)}
          onFocusOut={() => held.delete(one.id)}
        >
          {one.bad && <Icon name="warn" />}
          <div class="grow">
            <div>{one.text}</div>
            {one.detail && <div class="dim">{one.detail}</div>}
          </div>
          {one.action && (
            <button
              type="button"
              class="button dense"
              onClick={() => {
                one.action!.run();
                held.delete(one.id);
                dismiss(one.id);
              }}
            >
              {one.action.text}
            </button>
          )}
          <button
            type="button"
            class="button quiet icon dense"
            aria-label={w("button.close")}
            onClick={() => {
              held.delete(one.id);
              dismiss(one.id);
            }}
          >
            <Icon name="close" />
          </button>
        </div>
      ))}
    </div>
  );
}
