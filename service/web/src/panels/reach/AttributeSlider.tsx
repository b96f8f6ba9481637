/** A slider over an attribute, with the examples above it: dots, or their density; gaps and what lies outside are hatched. */
import { useMemo, useRef, useState } from "preact/hooks";
import { densityOf, onStep, stepOver } from "../../motion/timeline/phases";
import { Icon } from "../../ui/icons";
import { number } from "../../words";
import { endsOf, supportOf, type Attribute } from "./model";
import { nameOf, unitOf } from "./names";
import { b } from "./words";

const DENSE = 60; // examples from which on a density says more than dots
const LARGE = 10; // steps of PgUp and PgDn

export function AttributeSlider({
  attribute,
  value,
  onChange,
  onHome,
}: {
  attribute: Attribute;
  value: number;
  onChange: (value: number) => void;
  onHome: () => void;
}) {
  const track = useRef<HTMLDivElement>(null);
  const [text, setText] = useState<string | null>(null);
  const { name, unit, least, greatest, gaps, values } = attribute;
  const [low, high] = endsOf(attribute);
  const step = stepOver(greatest - least);
  const share = (at: number) => Math.max(0, Math.min(100, ((at - low) / (high - low)) * 100));
  const between = (from: number, to: number) => ({ left: `${share(from)}%`, width: `${share(to) - share(from)}%` });
  const support = supportOf(attribute, value);
  const cloud = useMemo(() => cloudOf(values, low, high), [values]);
  const set = (next: number) => {
    setText(null);
    onChange(Math.max(low, Math.min(high, onStep(next, step))));
  };
  const go = (event: PointerEvent) => {
    const bounds = track.current!.getBoundingClientRect();
    set(low + ((event.clientX - bounds.left) / bounds.width) * (high - low));
  };
  const title = nameOf(name);
  return (
    <div class="reach-slider">
      <div class="row">
        <strong class="grow">{title}</strong>
        {support !== "inside" && (
          <span class={`support ${support}`}>
            <Icon name="warn" />
            {b(`label.${support}`)}
          </span>
        )}
        <input
          class="field number"
          inputMode="decimal"
          aria-label={b("label.valueOf", { name: title })}
          value={text ?? String(onStep(value, step / 100))}
          onFocus={(event) => event.currentTarget.select()}
          onInput={(event) => setText(event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key === "Enter") event.currentTarget.blur();
          }}
          onBlur={() => {
            const said = Number((text ?? "").replace(",", "."));
            if (text?.trim() && Number.isFinite(said)) onChange(said);
            setText(null);
          }}
        />
        <span class="dim unit">{unitOf(unit)}</span>
      </div>
      <div
        class="slider-field"
        onPointerDown={(event) => {
          track.current!.focus();
          event.currentTarget.setPointerCapture(event.pointerId);
          go(event);
          event.currentTarget.onpointermove = go;
          event.preventDefault();
        }}
        onPointerUp={(event) => {
          event.currentTarget.onpointermove = null;
        }}
      >
        <svg class="slider-cloud" viewBox="0 0 1000 20" preserveAspectRatio="none" aria-hidden="true">
          {values.length >= DENSE ? <path d={cloud} /> : null}
        </svg>
        {values.length < DENSE &&
          values.map((one, at) => (
            <span key={at} class="slider-dot" style={{ left: `${share(one)}%`, top: `${4 + (at % 3) * 5}px` }} />
          ))}
        <div
          ref={track}
          class="slider-track"
          role="slider"
          tabIndex={0}
          aria-label={title}
          aria-valuemin={low}
          aria-valuemax={high}
          aria-valuenow={value}
          aria-valuetext={`${number(value, 4)} ${unitOf(unit)}, ${b(`label.${support}`)}`}
          onKeyDown={(event) => {
            if (event.key === "Home") onHome();
            else {
              const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -LARGE, PageUp: LARGE }[
                event.key
              ];
              if (!by) return;
              set(value + by * step);
            }
            event.preventDefault();
            event.stopPropagation();
          }}
        >
          <span class="slider-line" />
          <span class="slider-line done" style={{ width: `${share(value)}%` }} />
          <span class="slider-hatch outside" style={between(low, least)} />
          <span class="slider-hatch outside" style={between(greatest, high)} />
          {gaps.map(([from, to]) => (
            <span key={from} class="slider-hatch gap" style={between(from, to)} />
          ))}
          <span class={`slider-knob ${support}`} style={{ left: `${share(value)}%` }} />
        </div>
        <div class="slider-scale n" aria-hidden="true">
          <span style={{ left: `${share(least)}%` }}>{number(least, 2)}</span>
          {gaps
            .filter(([from, to]) => share(to) - share(from) > 24)
            .map(([from, to]) => (
              <span key={from} class="gap-name" style={{ left: `${share((from + to) / 2)}%` }}>
                {b("label.nobodyHere")}
              </span>
            ))}
          <span style={{ left: `${share(greatest)}%` }}>{number(greatest, 2)}</span>
        </div>
      </div>
    </div>
  );
}

function cloudOf(values: number[], low: number, high: number): string {
  const heights = densityOf(values, low, high, 120);
  let path = "M0 20";
  heights.forEach(
    (one, at) => (path += `L${(((at + 0.5) / heights.length) * 1000).toFixed(1)} ${(20 - one * 18).toFixed(1)}`),
  );
  return `${path}L1000 20Z`;
}
