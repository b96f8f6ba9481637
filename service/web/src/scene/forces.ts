/** Force plates on the floor, and arrows of the forces that they measure. */
import { numberAt } from "../lists";
import * as THREE from "three";
import { outlinesOf } from "../motion/body/forces";
import type { Skeleton } from "../motion/body/skeleton";

// In body heights.
const SHAFT = 0.006;
const HEAD = 0.016;
const HEAD_LENGTH = 0.05;
/** Of a short arrow, that is its head. */
const MOST_HEAD = 0.6;

const UP = new THREE.Vector3(0, 1, 0);
/** Of length 1 along +Y. */
const shaftShape = new THREE.CylinderGeometry(1, 1, 1, 10, 1).translate(0, 0.5, 0);
const headShape = new THREE.ConeGeometry(1, 1, 14, 1).translate(0, 0.5, 0);

export class Forces {
  readonly group = new THREE.Group();
  private readonly outlines: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private readonly material = new THREE.MeshBasicMaterial();
  private readonly shafts: THREE.InstancedMesh;
  private readonly heads: THREE.InstancedMesh;
  private readonly most: number;

  constructor(
    private readonly skeleton: Skeleton,
    token: (name: string) => string,
  ) {
    this.most = skeleton.view.plates.length;
    const sides = outlinesOf(skeleton.view).map((value) => value * skeleton.metres);
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(sides, 3));
    this.outlines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
    this.shafts = new THREE.InstancedMesh(shaftShape, this.material, this.most);
    this.heads = new THREE.InstancedMesh(headShape, this.material, this.most);
    for (const mesh of [this.shafts, this.heads]) {
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      mesh.frustumCulled = false;
    }
    this.group.add(this.outlines, this.shafts, this.heads);
    this.group.visible = false;
    this.recolour(token);
  }

  /** arrows: start and end (x y z each) of each, in the clip's unit; null: plates are hidden too. */
  show(arrows: Float32Array | null): void {
    this.group.visible = arrows !== null;
    if (!arrows) return;
    const { metres, height } = this.skeleton;
    const count = Math.min(this.most, arrows.length / 6);
    const at = (from: number) =>
      new THREE.Vector3(numberAt(arrows, from), numberAt(arrows, from + 1), numberAt(arrows, from + 2));
    for (let arrow = 0; arrow < count; arrow++) {
      const start = at(arrow * 6).multiplyScalar(metres);
      const along = at(arrow * 6 + 3)
        .multiplyScalar(metres)
        .sub(start);
      const length = along.length();
      const turn = new THREE.Quaternion().setFromUnitVectors(UP, along.normalize());
      const head = Math.min(HEAD_LENGTH * height, MOST_HEAD * length);
      const wide = head / HEAD_LENGTH;
      const neck = start.clone().addScaledVector(along, length - head);
      const shaft = new THREE.Vector3(SHAFT * wide, length - head, SHAFT * wide);
      this.shafts.setMatrixAt(arrow, new THREE.Matrix4().compose(start, turn, shaft));
      this.heads.setMatrixAt(
        arrow,
        new THREE.Matrix4().compose(neck, turn, new THREE.Vector3(HEAD * wide, head, HEAD * wide)),
      );
    }
    for (const mesh of [this.shafts, this.heads]) {
      mesh.count = count;
      mesh.instanceMatrix.needsUpdate = true;
    }
  }

  recolour(token: (name: string) => string): void {
    this.outlines.material.color.set(token("text3"));
    this.material.color.set(token("bad"));
  }

  dispose(): void {
    this.outlines.geometry.dispose();
    this.outlines.material.dispose();
    this.material.dispose();
    this.shafts.dispose();
    this.heads.dispose();
  }
}
