/** Keys and game pads that lead a body, seen from the camera. */
import { entryOf, numberAt } from "../../lists";
import type { Point } from "../../motion/matching/library";

const KEYS: Record<string, Point> = {
  KeyW: [0, 1],
  ArrowUp: [0, 1],
  KeyS: [0, -1],
  ArrowDown: [0, -1],
  KeyA: [-1, 0],
  ArrowLeft: [-1, 0],
  KeyD: [1, 0],
  ArrowRight: [1, 0],
};
const DEAD = 0.2; // of a stick that nobody touches

/** The keys that are down, as (to the right, ahead) of at most length 1. */
export class Leading {
  private readonly down = new Set<string>();

  /** Hold or release a key by its code. True for one that leads. */
  hold(code: string, on: boolean): boolean {
    if (!(code in KEYS)) return false;
    if (on) this.down.add(code);
    else this.down.delete(code);
    return true;
  }

  release(): void {
    this.down.clear();
  }

  get now(): Point {
    let [x, y] = padNow();
    for (const code of this.down) {
      const [right, ahead] = entryOf(KEYS, code);
      x += right;
      y += ahead;
    }
    const length = Math.hypot(x, y);
    return length > 1 ? [x / length, y / length] : [x, y];
  }
}

function padNow(): Point {
  const pad = typeof navigator.getGamepads === "function" ? navigator.getGamepads().find((one) => one !== null) : null;
  if (!pad) return [0, 0];
  const [x, y] = [numberAt(pad.axes, 0), -numberAt(pad.axes, 1)];
  return Math.hypot(x, y) > DEAD ? [x, y] : [0, 0];
}

/** A direction that the camera sees, on the ground. camera: its position and target in the world, Y up, as the stage
 * tells them. zUp: of the clips. */
export function onGround([right, ahead]: Point, camera: readonly number[], zUp: boolean): Point {
  const [x, , z] = camera as [number, number, number];
  const [forwardX, forwardZ] = [numberAt(camera, 3) - x, numberAt(camera, 5) - z];
  const length = Math.hypot(forwardX, forwardZ) || 1;
  const [ux, uz] = [forwardX / length, forwardZ / length];
  const [worldX, worldZ] = [ux * ahead - uz * right, uz * ahead + ux * right];
  // The ground is z, x where Y points up, and x, y where Z does, which the stage shows as x, -z.
  return zUp ? [worldX, -worldZ] : [worldZ, worldX];
}
