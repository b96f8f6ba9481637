/** The stage while a body is posed: the motion as it was beside the pose, and the arrows of the chosen handle. */
import { effect } from "@preact/signals";
import { numberAt } from "../../../lists";
import type { Vector } from "../../../motion/body/quaternions";
import { axisArrows, type Handle } from "../../../scene/handle";
import type { Stage } from "../../../scene/stage";
import type { Clip } from "../../../state/clip/clip";
import { number } from "../../../words";
import type { HeldHandle } from "../viewer/restPose";
import { JOINTS, type HandleName, type Moved } from "./handles";
import { posing, type Posing } from "./posing";

const DIGITS = 4;

export function poseHandle(clip: Clip, stage: Stage): HeldHandle {
  let ghost = -1;
  let own: Handle | null = null;
  let held: { name: string; handle: Handle; part: HandleName; start: Vector; before: Moved } | null = null;

  const draw = (handle: Handle | null) => {
    if (handle || stage.handle === own) stage.handle = handle;
    own = handle;
    stage.ask();
  };
  const stop = effect(() => {
    const made = posing.value;
    clip.blocks.arrived.value;
    const frame = clip.player.frame.value;
    const before = made && clip.positions(frame);
    const isPosed = Boolean(made?.positions(frame));
    if (ghost < 0 && isPosed) ghost = stage.add(clip.skeleton, { dim: true });
    if (ghost >= 0) stage.pose(ghost, { positions: isPosed ? before : null, before: [], trail: [] });
    draw(made && before && made.isWhole(frame) ? handleAt(made, before, held?.name ?? null) : null);
  });
  return {
    stop,
    grab(x, y) {
      const made = posing.peek();
      const part = made?.chosen.peek();
      const name = own && stage.handle === own ? stage.arrowAt(x, y) : null;
      if (!made || !part || !own || name === null) return false;
      clip.player.pause();
      held = { name, handle: own, part, start: stage.pullOf(own, name, x, y), before: made.moved(part) };
      stage.orbits = false;
      return true;
    },
    pull(x, y) {
      if (!held) return;
      const { handle, name, part, start, before } = held;
      const by = stage.pullOf(handle, name, x, y);
      const move = before.move.map((one, axis) =>
        Number((one + numberAt(by, axis) - numberAt(start, axis)).toFixed(DIGITS)),
      ) as Vector;
      posing.peek()?.set(part, { ...before, move });
    },
    drop() {
      held = null;
      stage.orbits = true;
      if (own) draw({ ...own, held: null });
    },
  };
}

/** The arrows of the chosen part, where it is to be. before: joints as they are without the pose. */
function handleAt(made: Posing, before: Float32Array, held: string | null): Handle | null {
  const part = made.chosen.value;
  const joint = part ? made.clip.skeleton.byName.get(JOINTS[part]) : undefined;
  if (!part || joint === undefined) return null;
  const { move } = made.moved(part);
  const at = move.map((one, axis) => one + numberAt(before, joint * 3 + axis)) as Vector;
  if (at.some(Number.isNaN)) return null;
  return {
    actor: 0,
    at,
    arrows: axisArrows(),
    free: true,
    held,
    words: move.some(Boolean) ? move.map((one) => number(one, 2)).join("  ") : "",
  };
}
