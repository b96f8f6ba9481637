/** Settings of all transitions that state none of their own: length, type, standing feet, phase of walks. */
import { heldSeconds, LONGEST_SECONDS } from "../../state/editing/composition";
import { w } from "../../words";
import type { Board } from "./board";
import { StyleChoice } from "./Forms";

const USUAL_RATE = 30; // frames a second, until a clip is known
const round = (seconds: number): number => Math.round(seconds * 100) / 100;

export function AllSeams({ board, body }: { board: Board; body: { perSecond: number } | undefined }) {
  const rate = body?.perSecond ?? USUAL_RATE;
  const { seconds, transition, style, lockFeet, matchPhase } = board.steps.now.value;
  return (
    <>
      <label class="row">
        <span class="dim">{w("label.allTransitions")}</span>
        <input
          class="field number"
          type="number"
          min={0}
          max={LONGEST_SECONDS}
          step={0.1}
          value={transition === null ? seconds : round(transition / rate)}
          onInput={(event) =>
            board.setAll({ seconds: heldSeconds(Number(event.currentTarget.value)), transition: null })
          }
        />
        <span class="dim">s</span>
      </label>
      <StyleChoice
        label={w("label.transition")}
        value={style}
        onChange={(one) => one && board.setAll({ style: one })}
      />
      <button
        type="button"
        class="button dense"
        aria-pressed={lockFeet}
        title={w("help.lockFeetHelp")}
        onClick={() => board.setAll({ lockFeet: !lockFeet })}
      >
        {w("label.lockFeet")}
      </button>
      <button
        type="button"
        class="button dense"
        aria-pressed={matchPhase}
        title={w("help.matchPhase")}
        onClick={() => board.setAll({ matchPhase: !matchPhase })}
      >
        {w("label.matchPhase")}
      </button>
    </>
  );
}
