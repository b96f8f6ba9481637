/** Where a camera has to be to see all of a body. */
import { numberAt } from "../lists";
import * as THREE from "three";

export type CameraView = "persp" | "front" | "side" | "top";

/** The direction to a camera, and how far away it has to be for a box of this size. */
export function viewOf(size: THREE.Vector3, camera: THREE.PerspectiveCamera, view: CameraView) {
  const fov = (camera.fov * Math.PI) / 360;
  const tall = size.y / 2 / Math.tan(fov);
  const wide = Math.hypot(size.x, size.z) / 2 / (Math.tan(fov) * camera.aspect);
  const away = Math.max(tall, wide, 0.2) * 1.35 + Math.max(size.x, size.z) / 2;
  const from = { persp: [0.62, 0.28, 1], front: [0, 0, 1], side: [1, 0, 0], top: [0, 1, 0.0001] }[view];
  return { direction: new THREE.Vector3().fromArray(from).normalize(), away };
}

/** Let a camera see what is so far away, and much nearer and farther. */
export function seeAsFarAs(camera: THREE.PerspectiveCamera, away: number): void {
  camera.near = away / 100;
  camera.far = away * 60;
  camera.updateProjectionMatrix();
}

/** A camera as text (position and target) so many times as far from its target. */
export function fartherOff(camera: string, times: number): string {
  const numbers = camera.split(",").map(Number);
  const target = numbers.slice(3);
  return [...target.map((one, axis) => one + (numberAt(numbers, axis) - one) * times), ...target].join(",");
}
