/** Two attributes at once: the examples as a cloud, the hull round them, gaps hatched, a cross that is dragged or moved by arrows. */
import { entryOf, itemAt, numberAt } from "../../lists";
import { useMemo, useRef, useState } from "preact/hooks";
import { hullOf, onStep, stepOver } from "../../motion/timeline/phases";
import { param, setParams } from "../../state/session/route";
import { number } from "../../words";
import { endsOf, type Attribute, type Model, type Values } from "./model";
import { nameOf, unitOf } from "./names";
import { b } from "./words";

export function Pad({
  model,
  values,
  onChange,
  onHome,
}: {
  model: Model;
  values: Values;
  onChange: (changes: Values) => void;
  onHome: () => void;
}) {
  const box = useRef<HTMLDivElement>(null);
  const [pair, setPair] = useState<[string, string]>(() => pairNow(model));
  const [x, y] = pair.map((name) => model.attributes.find((one) => one.name === name)!) as [Attribute, Attribute];
  const [[left, right], [low, high]] = [endsOf(x), endsOf(y)];
  const place = (at: Attribute, value: number) => {
    const [from, to] = endsOf(at);
    return ((value - from) / (to - from)) * 100;
  };
  const cloud = useMemo(() => {
    const points = x.values.map((one, at) => [place(x, one), 100 - place(y, numberAt(y.values, at))] as const);
    return {
      dots: points.map(([px, py]) => `M${px.toFixed(2)} ${py.toFixed(2)}h0`).join(""),
      hull: hullOf(points)
        .map(([px, py]) => `${px.toFixed(2)},${py.toFixed(2)}`)
        .join(" "),
    };
  }, [x, y]);
  const set = (one: number, other: number) =>
    onChange({
      [x.name]: Math.max(left, Math.min(right, onStep(one, stepOver(x.greatest - x.least)))),
      [y.name]: Math.max(low, Math.min(high, onStep(other, stepOver(y.greatest - y.least)))),
    });
  const go = (event: PointerEvent) => {
    const bounds = box.current!.getBoundingClientRect();
    set(
      left + ((event.clientX - bounds.left) / bounds.width) * (right - left),
      high - ((event.clientY - bounds.top) / bounds.height) * (high - low),
    );
  };
  const choose = (at: 0 | 1, name: string) => {
    const next: [string, string] = [...pair];
    // The same on both sides shows nothing: they change places.
    if (next[1 - at] === name) next[1 - at] = next[at];
    next[at] = name;
    setPair(next);
    setParams({ pad: next.join(",") });
  };
  const words = (one: Attribute) => `${nameOf(one.name)} ${number(entryOf(values, one.name), 4)} ${unitOf(one.unit)}`;
  const select = (at: 0 | 1, label: string) => (
    <label class="row dim">
      {label}
      <select class="field" value={pair[at]} onChange={(event) => choose(at, event.currentTarget.value)}>
        {model.attributes.map((one) => (
          <option key={one.name} value={one.name}>
            {nameOf(one.name)}
          </option>
        ))}
      </select>
    </label>
  );
  return (
    <div class="reach-pad">
      <div class="row wrap">
        {select(0, b("label.across"))}
        {select(1, b("label.upwards"))}
      </div>
      <div
        ref={box}
        class="pad"
        role="slider"
        tabIndex={0}
        aria-label={b("label.padOf", { x: nameOf(x.name), y: nameOf(y.name) })}
        aria-valuemin={left}
        aria-valuemax={right}
        aria-valuenow={values[x.name]}
        aria-valuetext={`${words(x)}, ${words(y)}`}
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          event.currentTarget.focus();
          go(event);
          event.currentTarget.onpointermove = go;
          event.preventDefault();
        }}
        onPointerUp={(event) => {
          event.currentTarget.onpointermove = null;
        }}
        onKeyDown={(event) => {
          const by = {
            ArrowLeft: [-1, 0],
            ArrowRight: [1, 0],
            ArrowDown: [0, -1],
            ArrowUp: [0, 1],
            PageDown: [0, -10],
            PageUp: [0, 10],
          }[event.key];
          if (event.key === "Home") onHome();
          else if (by)
            set(
              entryOf(values, x.name) + numberAt(by, 0) * stepOver(x.greatest - x.least),
              entryOf(values, y.name) + numberAt(by, 1) * stepOver(y.greatest - y.least),
            );
          else return;
          event.preventDefault();
          event.stopPropagation();
        }}
      >
        {x.gaps.map(([from, to]) => (
          <span
            key={`x${from}`}
            class="slider-hatch gap"
            style={{ left: `${place(x, from)}%`, width: `${place(x, to) - place(x, from)}%`, top: "0", bottom: "0" }}
          />
        ))}
        {y.gaps.map(([from, to]) => (
          <span
            key={`y${from}`}
            class="slider-hatch gap"
            style={{
              top: `${100 - place(y, to)}%`,
              height: `${place(y, to) - place(y, from)}%`,
              left: "0",
              right: "0",
            }}
          />
        ))}
        <svg viewBox="0 0 100 100" preserveAspectRatio="none" aria-hidden="true">
          <polygon points={cloud.hull} />
          <path d={cloud.dots} />
        </svg>
        <span class="pad-x" style={{ left: `${place(x, entryOf(values, x.name))}%` }} />
        <span class="pad-y" style={{ top: `${100 - place(y, entryOf(values, y.name))}%` }} />
        <span
          class="slider-knob"
          style={{ left: `${place(x, entryOf(values, x.name))}%`, top: `${100 - place(y, entryOf(values, y.name))}%` }}
        />
      </div>
    </div>
  );
}

function pairNow(model: Model): [string, string] {
  const names = model.attributes.map((one) => one.name);
  const [one = "", other = ""] = param("pad").split(",");
  return names.includes(one) && names.includes(other) && one !== other
    ? [one, other]
    : [itemAt(names, 0), names.at(-1)!];
}
