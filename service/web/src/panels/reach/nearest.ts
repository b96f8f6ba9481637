/** The example nearest to the sliders, in the phase that the made motion is in. Asked for when the hand rests. */
import { batch, effect, signal, type ReadonlySignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { samePhase, type Moments } from "../../motion/timeline/phases";
import { motionOf, type Motion } from "../../motion/loading/source";
import type { Skeleton } from "../../motion/body/skeleton";
import type { Blending } from "./blending";
import { momentsOf } from "./model";

const REST = 120; // ms of rest before another example is fetched

export interface Nearest {
  /** The body that is drawn: of the first example seen, so that the stage stays. null: none is there yet. */
  body: ReadonlySignal<Skeleton | null>;
  /** Whether an example came, or none could be had: its document may be gone. */
  settled: ReadonlySignal<boolean>;
  /** Positions of the example while the made motion shows a frame. */
  pose: (frame: number) => Float32Array | null;
}

export function useNearest(blending: Blending): Nearest {
  const state = useMemo(
    () => ({
      body: signal<Skeleton | null>(null),
      settled: signal(false),
      now: signal<{ motion: Motion; moments: Moments } | null>(null),
    }),
    [blending],
  );
  useEffect(() => {
    let timer = 0;
    let last = "";
    const stop = effect(() => {
      const near = blending.shown.value?.answer.skeleton_source;
      if (!near || near.document === last) return;
      last = near.document;
      window.clearTimeout(timer);
      const fetch = () =>
        void motionOf(near.document, near.revision).then(
          (motion) => {
            const row = blending.model.byId.get(near.document);
            if (!row || last !== near.document) return;
            motion.blocks.want(0, 1, motion.perSecond);
            state.now.value = { motion, moments: momentsOf(row)! };
            batch(() => {
              state.body.value ??= motion.skeleton;
              state.settled.value = true;
            });
          },
          () => (state.settled.value = true),
        );
      timer = window.setTimeout(fetch, state.now.peek() ? REST : 0);
    });
    return () => {
      stop();
      window.clearTimeout(timer);
    };
  }, [blending]);
  const pose = (frame: number): Float32Array | null => {
    const now = state.now.value;
    const shown = blending.shown.value;
    if (!now || !shown || now.motion.skeleton.points !== state.body.peek()?.points) return null;
    const { blocks, frames } = now.motion;
    blocks.arrived.value;
    return blocks.frame(Math.min(frames - 1, Math.round(samePhase(frame, shown.moments, now.moments))));
  };
  return { body: state.body, settled: state.settled, pose };
}
