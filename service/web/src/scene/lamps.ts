/** The lamps of the stage: one from the front, one from behind. */
import * as THREE from "three";

export function lamps(): THREE.DirectionalLight[] {
  const sun = new THREE.DirectionalLight(0xffffff, 1.7);
  sun.position.set(1.5, 4, 2.5);
  const back = new THREE.DirectionalLight(0xffffff, 0.5);
  back.position.set(-2, 2, -3);
  return [sun, back];
}
