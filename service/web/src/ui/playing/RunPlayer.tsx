/** Runs of frames, played one after the other. */
import { itemAt } from "../../lists";
import { effect, signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import type { Schemas } from "../../api/client";
import { motionOf, type Motion } from "../../motion/loading/source";
import { Player } from "../../state/clip/player";
import { Icon } from "../icons";
import { MotionView, type Actor } from "./MotionView";
import { Trouble } from "../Trouble";
import { number, w } from "../../words";
import "../../styles/runs.css";

const LEAST_SHOWN = 1200; // ms
type Run = Pick<Schemas["RunItem"], "document" | "name" | "revision" | "first" | "last">;

export function RunPlayer({ runs, at, onAt }: { runs: Run[]; at: number; onAt: (at: number) => void }) {
  const run = itemAt(runs, Math.min(at, runs.length - 1));
  const [motion, setMotion] = useState<Motion | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [playing, setPlaying] = useState(true);
  const frame = useMemo(() => signal(run.first - 1), []);
  useEffect(() => {
    let alive = true;
    motionOf(run.document, run.revision).then(
      (found) => alive && (setMotion(found), setError(null)),
      (problem) => alive && setError(problem),
    );
    return () => {
      alive = false;
    };
  }, [run.document, run.revision]);
  const actors = useMemo<Actor[]>(
    () =>
      motion
        ? [
            {
              skeleton: motion.skeleton,
              positions: () => {
                motion.blocks.arrived.value;
                return motion.blocks.frame(frame.value);
              },
            },
          ]
        : [],
    [motion],
  );
  useEffect(() => {
    if (!motion || motion.id !== run.document) return;
    const player = new Player(motion.frames, motion.perSecond);
    player.loop.value = [run.first - 1, run.last - 1];
    player.seek(run.first - 1);
    let before = run.first - 1;
    const began = performance.now();
    const stop = effect(() => {
      const now = player.frame.value;
      motion.blocks.want(now, 1, motion.perSecond);
      frame.value = now;
      // The run has begun again: the next one's turn, once this one was long enough in sight.
      if (now < before && runs.length > 1 && performance.now() - began > LEAST_SHOWN) {
        before = now;
        setTimeout(() => onAt((at + 1) % runs.length));
      }
      before = now;
    });
    if (playing) player.play(1);
    // A run of one frame stands still for a moment.
    const still =
      run.last === run.first && playing && runs.length > 1
        ? window.setTimeout(() => onAt((at + 1) % runs.length), LEAST_SHOWN)
        : 0;
    return () => {
      stop();
      player.pause();
      window.clearTimeout(still);
    };
  }, [motion, at, playing, runs]);
  return (
    <div class="run-player" aria-label={w("label.playResults")}>
      <Trouble error={error} />
      <MotionView actors={actors} label={run.name} />
      <div class="transport row">
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("label.backFrame")}
          disabled={at === 0}
          onClick={() => onAt(at - 1)}
        >
          <Icon name="first" />
        </button>
        <button
          type="button"
          class="button quiet icon play"
          aria-label={w(playing ? "button.pause" : "button.play")}
          onClick={() => setPlaying(!playing)}
        >
          <Icon name={playing ? "pause" : "play"} />
        </button>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("label.nextFrame")}
          disabled={at >= runs.length - 1}
          onClick={() => onAt(at + 1)}
        >
          <Icon name="last" />
        </button>
        <span class="cut grow">
          <strong>{run.name}</strong>{" "}
          <span class="dim">
            {number(run.first)}
            {run.last > run.first && `–${number(run.last)}`}
          </span>
        </span>
        <a class="button dense" href={`/clips/${run.document}?f=${run.first}&in=${run.first}&out=${run.last}`}>
          {w("button.open")}
        </a>
      </div>
    </div>
  );
}
