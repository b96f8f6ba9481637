/** A line between two panels that is dragged, moved by arrow keys, and reset by a double click. */
import type { Signal } from "@preact/signals";

export function Splitter({
  size,
  least,
  most,
  initial,
  label,
  axis = "x",
  from = "end",
}: {
  size: Signal<number>;
  least: number;
  most: number;
  initial: number;
  label: string;
  axis?: "x" | "y";
  /** The side of the splitter where the sized panel is. */
  from?: "start" | "end";
}) {
  const set = (value: number) => (size.value = Math.max(least, Math.min(most, Math.round(value))));
  const sign = from === "end" ? -1 : 1;
  return (
    <div
      class={`splitter ${axis}`}
      role="separator"
      tabIndex={0}
      aria-label={label}
      aria-orientation={axis === "x" ? "vertical" : "horizontal"}
      aria-valuenow={size.value}
      aria-valuemin={least}
      aria-valuemax={most}
      onDblClick={() => set(initial)}
      onKeyDown={(event) => {
        const step = { ArrowLeft: -16, ArrowUp: -16, ArrowRight: 16, ArrowDown: 16 }[event.key];
        if (step) {
          set(size.value + sign * step);
          event.preventDefault();
        }
      }}
      onPointerDown={(event) => {
        const element = event.currentTarget;
        element.setPointerCapture(event.pointerId);
        const [start, before] = [axis === "x" ? event.clientX : event.clientY, size.value];
        element.onpointermove = (move) => set(before + sign * ((axis === "x" ? move.clientX : move.clientY) - start));
        element.onpointerup = () => {
          element.onpointermove = null;
          element.onpointerup = null;
        };
      }}
    />
  );
}
