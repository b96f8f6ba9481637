/** The rest pose beside the body, and the arrows by which the selected bone is moved and lengthened there. */
import { numberAt } from "../../../lists";
import { effect } from "@preact/signals";
import type { Vector } from "../../../motion/body/quaternions";
import { baseOf, restOf, vectorOf } from "../../../motion/body/shape";
import { axisArrows, type Handle } from "../../../scene/handle";
import type { Stage } from "../../../scene/stage";
import type { Clip } from "../../../state/clip/clip";
import type { Draft } from "../../../state/editing/draft";
import { param } from "../../../state/session/route";
import type { Puller } from "../../../ui/playing/MotionView";
import { number } from "../../../words";
import { cameraView, shown } from "../actions";
import { posing } from "../posing/posing";

const BESIDE = -0.65; // body heights; clips that are compared stand on the other side
const ALONG = "along";

export const restShown = (): boolean => !posing.value && (Boolean(shown.value.rest) || param("tab") === "structure");

/** Arrows on the stage that a hand pulls. */
export interface HeldHandle extends Puller {
  stop: () => void;
}

export function restPose(clip: Clip, stage: Stage): HeldHandle {
  const { skeleton } = clip;
  let actor = -1;
  let wasShown = false;
  let own: Handle | null = null;
  let held: { name: string; handle: Handle; bone: number; vector: Vector; start: Vector; before: Draft } | null = null;

  const hide = () => {
    if (actor >= 0) stage.pose(actor, { positions: null, before: [], trail: [] });
    // A pose in the making has arrows of its own.
    if (stage.handle === own) stage.handle = null;
    own = null;
    wasShown = false;
    stage.ask();
  };
  const stop = effect(() => {
    if (!restShown() || skeleton.view.markers) {
      hide();
      return;
    }
    clip.blocks.arrived.value;
    const shape = clip.shape.value;
    const now = clip.positions(clip.player.frame.value);
    if (!now) return;
    const positions = standing(clip, restOf(skeleton), restOf(shape), now, stage.floorHeight);
    if (actor < 0) actor = stage.add(skeleton, { shift: BESIDE * skeleton.height, dim: true });
    stage.pose(actor, { positions, before: [], trail: [] });
    const name = clip.selection.value.bones[0];
    const bone = name === undefined ? undefined : skeleton.byName.get(name);
    stage.handle = own =
      bone === undefined || clip.pinned !== null ? null : handleOf(clip, bone, positions, actor, held?.name ?? null);
    if (!wasShown && !stage.sees(actor)) stage.frame(cameraView.peek());
    wasShown = true;
  });
  return {
    stop,
    grab(x, y) {
      const name = own && stage.handle === own ? stage.arrowAt(x, y) : null;
      const bone = skeleton.byName.get(clip.selection.peek().bones[0] ?? "");
      if (name === null || bone === undefined || !own) return false;
      clip.player.pause();
      const handle = own;
      held = {
        name,
        handle,
        bone,
        vector: vectorOf(clip.shape.peek().view, bone)!,
        start: stage.pullOf(handle, name, x, y),
        before: clip.draft.peek(),
      };
      stage.orbits = false;
      return true;
    },
    pull(x, y) {
      if (!held) return;
      const { handle, name, vector, start } = held;
      const { direction } = handle.arrows.find((one) => one.name === name)!;
      const by = stage.pullOf(handle, name, x, y);
      const next = vector.map((one, axis) => one + numberAt(by, axis) - numberAt(start, axis)) as Vector;
      // A bone keeps some length and does not turn over by being pulled through its joint.
      if (
        name === ALONG &&
        next.reduce((sum, one, axis) => sum + one * numberAt(direction, axis), 0) <= 1e-3 * Math.hypot(...vector)
      )
        return;
      clip.setBone(held.bone, next, held.before);
    },
    drop() {
      held = null;
      stage.orbits = true;
      if (own) stage.handle = own = { ...own, held: null };
      stage.ask();
    },
  };
}

/** The rest pose where the body is, as it stands before anything was changed: what is pulled does not move its own ground. */
function standing(
  { skeleton }: Clip,
  stored: Float32Array,
  rest: Float32Array,
  now: Float32Array,
  floor: number,
): Float32Array {
  const up = skeleton.zUp ? 2 : 1;
  let lowest = Infinity;
  for (let at = up; at < stored.length; at += 3) lowest = Math.min(lowest, numberAt(stored, at));
  const root = [0, 1, 2].map((axis) => (axis === up ? floor / skeleton.metres - lowest : numberAt(now, axis)));
  return rest.map((value, at) => value + numberAt(root, at % 3));
}

function handleOf(
  clip: Clip,
  bone: number,
  positions: Float32Array,
  actor: number,
  held: string | null,
): Handle | null {
  const shape = clip.shape.peek();
  const vector = vectorOf(shape.view, bone);
  if (!vector) return null;
  const base = baseOf(shape.view, bone);
  const at = [0, 1, 2].map((axis) => numberAt(positions, base * 3 + axis) + numberAt(vector, axis)) as Vector;
  const length = Math.hypot(...vector);
  const arrows = axisArrows();
  if (length)
    arrows.push({ name: ALONG, direction: vector.map((one) => one / length) as Vector, token: "select", reach: 1.45 });
  const words = `${vector.map((one) => number(one, 2)).join("  ")}   ${number(length * clip.skeleton.metres * 100, 1)} cm`;
  return { actor, at, arrows, held, words };
}
