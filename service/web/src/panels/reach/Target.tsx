/** A place for the hand at the end of the reach: three numbers in metres, and how far the hand is from it. */
import { itemAt } from "../../lists";
import { useState } from "preact/hooks";
import { number } from "../../words";
import type { Blending, Place } from "./blending";
import { b } from "./words";

const AXES = ["X", "Y", "Z"] as const;
const DIGITS = 3;

export function Target({ blending }: { blending: Blending }) {
  const answer = blending.shown.value?.answer;
  const target = blending.target.value;
  const shown = blending.place.value;
  const missed = blending.missed.value;
  // A model of an earlier release, or without a unit of length, takes no target.
  if (!shown) return null;
  return (
    <details
      class="pad-fold"
      open={blending.aiming.value}
      onToggle={(event) => (blending.aiming.value = event.currentTarget.open)}
    >
      <summary>{b("label.target")}</summary>
      <p class="dim">{b("help.target")}</p>
      <div class="row wrap">
        {AXES.map((axis, place) => (
          <Coordinate
            key={axis}
            axis={axis}
            value={itemAt(shown, place)}
            onChange={(value) => {
              const moved: Place = [...shown];
              moved[place] = value;
              blending.aim(moved);
            }}
          />
        ))}
        {target && (
          <button type="button" class="button" onClick={() => blending.aim(null)}>
            {b("button.removeTarget")}
          </button>
        )}
      </div>
      {target && missed && (
        <p class="row wrap" role="status">
          <span class="guess">{b("label.outOfReach", { size: number(missed.distance * 100, 1) })}</span>
          <button
            type="button"
            class="button dense"
            onClick={() => blending.aim(missed.nearest.map((one) => Number(one.toFixed(DIGITS))) as Place)}
          >
            {b("button.nearestPlace")}
          </button>
        </p>
      )}
      {target && !missed && answer?.hand_error != null && (
        <p role="status">{b("label.handError", { size: number(answer.hand_error * 100, 1) })}</p>
      )}
    </details>
  );
}

function Coordinate({ axis, value, onChange }: { axis: string; value: number; onChange: (value: number) => void }) {
  const [text, setText] = useState<string | null>(null);
  return (
    <label class="row">
      {axis}
      <input
        class="field number"
        inputMode="decimal"
        aria-label={b("label.targetAxis", { axis })}
        value={text ?? String(value)}
        onFocus={(event) => event.currentTarget.select()}
        onInput={(event) => setText(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
        }}
        onBlur={() => {
          const typed = Number((text ?? "").replace(",", "."));
          if (text?.trim() && Number.isFinite(typed)) onChange(typed);
          setText(null);
        }}
      />
      <span class="dim unit">m</span>
    </label>
  );
}
