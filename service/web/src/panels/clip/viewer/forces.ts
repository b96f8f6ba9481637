/** Forces of the plates of a clip, in step with its frames. */
import { effect } from "@preact/signals";
import { arrowsOf, quantitiesOf } from "../../../motion/body/forces";
import { Blocks, quantitiesOf as sourceOf } from "../../../motion/loading/blocks";
import type { Clip } from "../../../state/clip/clip";
import { refuse } from "../../../state/session/notes";

/** Plates of one request, which takes at most 100 quantities. */
const AT_ONCE = 16;

export interface Forces {
  /** Arrows of a frame (from 0), none while they are on their way. Signals that it reads move when they came. */
  at(frame: number): Float32Array;
  close(): void;
}

export function forcesOf({ detail, skeleton, player }: Clip): Forces {
  const { plates, frames, origin } = skeleton.view;
  const names = plates.flatMap(({ name }) => name ?? []);
  const parts: Blocks[] = [];
  for (let from = 0; from < names.length; from += AT_ONCE) {
    const asked = names.slice(from, from + AT_ONCE).flatMap(quantitiesOf);
    parts.push(new Blocks(sourceOf(detail.id, detail.revision, frames, asked)));
  }
  let isTold = false;
  const stop = effect(() => {
    const trouble = parts.map((part) => part.trouble.value).find((each) => each !== null);
    if (!trouble || isTold) return;
    isTold = true;
    refuse(trouble);
  });
  return {
    at(frame) {
      const direction = player.playing.value ? Math.sign(player.speed.value) : 0;
      const numbers = parts.flatMap((part) => {
        part.arrived.value;
        part.want(frame, direction, player.perSecond * Math.abs(player.speed.peek()), player.range[0]);
        return [...(part.frame(frame) ?? [])];
      });
      return arrowsOf(numbers, origin, skeleton.metres);
    },
    close() {
      stop();
      for (const part of parts) part.close();
    },
  };
}
