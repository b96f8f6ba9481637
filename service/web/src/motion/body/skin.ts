/** A mesh that follows joints: what the server makes to the measure of a skeleton, and where it is in a pose. */
import { itemAt, numberAt } from "../../lists";
import type { Schemas } from "../../api/client";
import { inverse, multiply, type Quaternion } from "./quaternions";

export interface Skin {
  /** (vertices, 3) in the clip's unit and axes, from the first joint of the pose that the mesh is bound in. */
  points: Float32Array;
  triangles: Uint32Array;
  joints: Uint16Array; // (vertices, 4)
  weights: Float32Array; // (vertices, 4)
  /** (joints, 3) from the same place, and (joints, 4) rotations from rest, in that pose. */
  places: Float64Array;
  turns: Quaternion[];
  /** Joints that a vertex follows. */
  used: number[];
  /** Red, green and blue of each vertex, 0 to 255 of sRGB; null: it is coloured by its sides. */
  colours: Uint8Array | null;
  normals: Float32Array | null;
  /** Where joints of its own are drawn; null: it follows the joints of the clip. */
  own: Place | null;
}

/** How the space of a character's joints is in the clip's. metres: of a unit of the character, drawn as large as the
 * clip's body. origin: (3,) of the clip in its unit, which it is drawn from. */
export interface Place {
  metres: number;
  zUp: boolean;
  origin: readonly number[];
}

/** The joints of a skin that has its own: positions (joints, 3), and rotations (joints, 4) from rest. */
export interface Worn {
  positions: Float32Array;
  turns: Float32Array;
}

export function skinOf(mesh: Schemas["CharacterMesh"], own: Place | null = null): Skin {
  const origin = itemAt(mesh.bind_positions, 0);
  // Far from the origin single precision is coarse.
  const from = (value: number, at: number) => value - numberAt(origin, at % 3);
  const joints = Uint16Array.from(mesh.joints);
  const weights = Float32Array.from(mesh.weights);
  return {
    points: Float32Array.from(mesh.points, from),
    triangles: Uint32Array.from(mesh.triangles),
    joints,
    weights,
    places: Float64Array.from(mesh.bind_positions.flat(), from),
    turns: mesh.bind_rotations.map((turn) => [...turn] as Quaternion),
    used: [...new Set(joints.filter((_, at) => numberAt(weights, at) > 0))],
    colours: mesh.colours ? Uint8Array.from(mesh.colours) : null,
    normals: mesh.normals ? Float32Array.from(mesh.normals) : null,
    own,
  };
}

/**
 * Where the mesh goes with each joint: 4 × 4 matrices (joints, 16), column after column, from the points of the skin to
 * metres. False where a joint that it needs is not known; then nothing is promised of the matrices.
 *
 * positions: (points, 3) in the clip's unit. turns: (joints, 4) from rest in the world.
 */
export function moveSkin(
  skin: Skin,
  positions: ArrayLike<number>,
  turns: ArrayLike<number>,
  metres: number,
  into: Float32Array,
): boolean {
  for (const joint of skin.used) {
    const turn: Quaternion = [0, 1, 2, 3].map((part) => numberAt(turns, joint * 4 + part)) as Quaternion;
    const [x, y, z, w] = multiply(turn, inverse(itemAt(skin.turns, joint)));
    const at = joint * 16;
    into[at] = (1 - 2 * (y * y + z * z)) * metres;
    into[at + 1] = 2 * (x * y + z * w) * metres;
    into[at + 2] = 2 * (x * z - y * w) * metres;
    into[at + 3] = 0;
    into[at + 4] = 2 * (x * y - z * w) * metres;
    into[at + 5] = (1 - 2 * (x * x + z * z)) * metres;
    into[at + 6] = 2 * (y * z + x * w) * metres;
    into[at + 7] = 0;
    into[at + 8] = 2 * (x * z + y * w) * metres;
    into[at + 9] = 2 * (y * z - x * w) * metres;
    into[at + 10] = (1 - 2 * (x * x + y * y)) * metres;
    into[at + 11] = 0;
    for (let axis = 0; axis < 3; axis++) {
      let moved = numberAt(positions, joint * 3 + axis) * metres;
      for (let part = 0; part < 3; part++)
        moved -= numberAt(into, at + part * 4 + axis) * numberAt(skin.places, joint * 3 + part);
      if (!Number.isFinite(moved)) return false;
      into[at + 12 + axis] = moved;
    }
    into[at + 15] = 1;
  }
  return true;
}

/** The joint that each vertex follows most. */
export function leadersOf({ joints, weights }: Skin): Uint16Array {
  return Uint16Array.from({ length: joints.length / 4 }, (_, vertex) => {
    let best = vertex * 4;
    for (let slot = best + 1; slot < vertex * 4 + 4; slot++)
      if (numberAt(weights, slot) > numberAt(weights, best)) best = slot;
    return numberAt(joints, best);
  });
}
