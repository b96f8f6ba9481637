/** Lines that points have gone along. */
import { numberAt } from "../lists";
import type * as THREE from "three";

/** Put lines (points of x y z in the clip's unit) into the room that the segments have; what is not seen leaves a gap. */
export function fillTrails(trails: THREE.LineSegments, lines: Float32Array[], metres: number): void {
  const attribute = trails.geometry.getAttribute("position") as THREE.BufferAttribute;
  const room = attribute.array as Float32Array;
  let used = 0;
  for (const line of lines) {
    for (let at = 0; at + 5 < line.length && used + 6 <= room.length; at += 3) {
      for (let axis = 0; axis < 6; axis++) room[used + axis] = numberAt(line, at + axis) * metres;
      if (room[used] === room[used] && room[used + 3] === room[used + 3]) used += 6;
    }
  }
  trails.geometry.setDrawRange(0, used / 3);
  attribute.needsUpdate = true;
  trails.visible = used > 0;
}
