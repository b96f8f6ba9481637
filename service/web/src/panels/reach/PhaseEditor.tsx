/** The phases of one clip on its angular speed: dragged, moved by keys, or written as frames. */
import { numberAt } from "../../lists";
import { useMemo, useRef, useState } from "preact/hooks";
import { number } from "../../words";
import { moved, type Corrections, type Times } from "./corrections";
import type { Model, Row } from "./model";
import { PhaseChart } from "./PhaseChart";
import { reasonOf } from "./names";
import { b } from "./words";

const FIELDS = ["t1", "t2", "end"] as const;

export function PhaseEditor({
  model,
  row,
  corrections,
  values,
}: {
  model: Model;
  row: Row;
  corrections: Corrections;
  values: ArrayLike<number> | null;
}) {
  const gesture = useRef(0);
  const last = (values?.length ?? 2) - 1;
  const times = corrections.timesOf(row);
  const curve = useMemo(() => ({ values: values ?? [], fps: row.fps }), [values]);
  const most = useMemo(() => {
    let top = 0;
    for (let at = 0; at < curve.values.length; at++) top = Math.max(top, numberAt(curve.values, at));
    return top * 1.05 || 1;
  }, [curve]);
  const move = (which: keyof Times, frame: number) => {
    if (times) corrections.setTimes(row.document, moved(times, which, frame, last), `${which} ${gesture.current}`);
  };
  return (
    <section class="phase-editor" aria-label={b("label.phasesOf", { name: row.name })}>
      <div class="row wrap">
        <h2 class="cut">{row.name}</h2>
        {!row.used && <span class="dim">{reasonOf(row.reason ?? "")}</span>}
        <span class="grow" />
        {times ? (
          FIELDS.map((one) => (
            <TimeField
              key={one}
              name={one}
              value={times[one]}
              fps={row.fps}
              onChange={(frame) => {
                move(one, frame);
                gesture.current++;
              }}
            />
          ))
        ) : (
          <button
            type="button"
            class="button"
            disabled={!values}
            onClick={() => corrections.setTimes(row.document, guess(model, last))}
          >
            {b("button.setByHand")}
          </button>
        )}
        {corrections.isSet(row.document) && (
          <button type="button" class="button quiet" onClick={() => corrections.setTimes(row.document, null)}>
            {b("button.asFound")}
          </button>
        )}
        <a class="button quiet" href={`/clips/${row.document}`}>
          {b("button.openClip")}
        </a>
      </div>
      {values ? (
        <PhaseChart
          curve={curve}
          times={times}
          seconds={Math.max(last, times?.end ?? 0) / row.fps}
          most={most}
          label={b("label.speedOf", { joint: model.summary.phase_joint, name: row.name })}
          onMove={move}
          onEnd={() => gesture.current++}
        />
      ) : (
        <div class="busy" />
      )}
    </section>
  );
}

function TimeField({
  name,
  value,
  fps,
  onChange,
}: {
  name: (typeof FIELDS)[number];
  value: number;
  fps: number;
  onChange: (frame: number) => void;
}) {
  const [text, setText] = useState<string | null>(null);
  const keep = () => {
    const said = Number((text ?? "").replace(",", "."));
    if (text?.trim() && Number.isFinite(said)) onChange(said);
    setText(null);
  };
  return (
    <label class="row time-field" title={b(`label.${name}Edge`)}>
      <span>{name === "end" ? b("label.endShort") : name}</span>
      <input
        class="field number"
        inputMode="decimal"
        aria-label={`${b(`label.${name}Edge`)}, ${b("label.inFrames")}`}
        value={text ?? String(Math.round(value * 10) / 10)}
        onInput={(event) => setText(event.currentTarget.value)}
        onBlur={keep}
        onKeyDown={(event) => {
          const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
          if (event.key === "Enter") keep();
          else if (step) {
            setText(null);
            onChange(value + step * (event.shiftKey ? 0.1 : 1));
            event.preventDefault();
          }
        }}
      />
      <span class="dim n">{number(value / fps, 2)} s</span>
    </label>
  );
}

/** Where phases usually are, in a clip in which none were found. */
function guess({ used }: Model, last: number): Times {
  const mean = (of: (row: Row) => number) => used.reduce((sum, row) => sum + of(row), 0) / used.length;
  const share = (name: "t1_frames" | "t2_frames") => mean((row) => row[name]! / row.end_frames!);
  return {
    t1: Math.round(share("t1_frames") * last * 10) / 10,
    t2: Math.round(share("t2_frames") * last * 10) / 10,
    end: last,
  };
}
