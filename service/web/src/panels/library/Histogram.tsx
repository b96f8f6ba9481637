/** Numbers of clips by a range of numbers: dragged over, pressed, or given in two fields. */
import { numberAt } from "../../lists";
import { useSignal } from "@preact/signals";
import type { Schemas } from "../../api/client";
import { isInRange, rangeOfBins, readRange, writeRange } from "../../state/library/ranges";
import { NumberField } from "../../ui/forms/NumberField";
import { useRoving } from "../../ui/useRoving";
import { number, w } from "../../words";

export function Histogram({
  histogram,
  label,
  chosen,
  onChoose,
  text,
}: {
  histogram: Schemas["Histogram"];
  /** What the numbers are. */
  label: string;
  /** "2..10", or "" */
  chosen: string;
  onChoose: (range: string | null) => void;
  text: (value: number) => string;
}) {
  const { ref: box, ...roving } = useRoving<HTMLDivElement>("button:not(:disabled)");
  const brush = useSignal<[number, number] | null>(null);
  const { edges, counts } = histogram;
  const most = Math.max(...counts, 1);
  const range = brush.value ? rangeOfBins(edges, ...brush.value) : readRange(chosen);
  const any = brush.value !== null || chosen !== "";
  const binAt = (event: PointerEvent) => {
    const bounds = box.current!.getBoundingClientRect();
    return Math.max(
      0,
      Math.min(counts.length - 1, Math.floor(((event.clientX - bounds.left) / bounds.width) * counts.length)),
    );
  };
  const choose = (from: number, to: number) => {
    const next = writeRange(rangeOfBins(edges, from, to));
    onChoose(next === chosen ? null : next);
  };
  const [least, greatest] = readRange(chosen);
  const field = (
    word: "trimFrom" | "trimTo",
    value: number | null,
    end: number,
    set: (value: number | null) => string | null,
  ) => (
    <NumberField
      label={`${label}, ${w(`label.${word}`)}`}
      placeholder={String(Number(end.toPrecision(3)))}
      value={value}
      onChange={(now) => onChoose(set(now))}
    />
  );
  return (
    <>
      <div
        ref={box}
        {...roving}
        class={`histogram ${any ? "chosen" : ""}`}
        onPointerDown={(event) => {
          if (event.button) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          brush.value = [binAt(event), binAt(event)];
        }}
        onPointerMove={(event) => {
          if (brush.value) brush.value = [brush.value[0], binAt(event)];
        }}
        onPointerUp={() => {
          const made = brush.value;
          brush.value = null;
          if (made) choose(...made);
        }}
        onPointerCancel={() => (brush.value = null)}
      >
        {counts.map((count, bin) => {
          const words = `${text(numberAt(edges, bin))} – ${text(numberAt(edges, bin + 1))}: ${number(count)}`;
          return (
            <button
              key={bin}
              type="button"
              class={count ? "" : "none"}
              disabled={!count}
              title={words}
              aria-label={words}
              aria-pressed={any && isInRange(edges, bin, range)}
              style={{ height: `${count ? 4 + 40 * Math.sqrt(count / most) : 3}px` }}
              onClick={(event) => {
                if (!event.detail) choose(bin, bin);
              }}
            />
          );
        })}
      </div>
      <div class="histogram-ends">
        <span>{text(numberAt(edges, 0))}</span>
        <span>{text(numberAt(edges, edges.length - 1))}</span>
      </div>
      <div class="histogram-fields row">
        {field("trimFrom", least, numberAt(edges, 0), (value) => writeRange([value, greatest]))}
        <span class="dim">–</span>
        {field("trimTo", greatest, numberAt(edges, edges.length - 1), (value) => writeRange([least, value]))}
        {chosen && (
          <button type="button" class="button quiet dense" onClick={() => onChoose(null)}>
            {w("button.clear")}
          </button>
        )}
      </div>
    </>
  );
}
