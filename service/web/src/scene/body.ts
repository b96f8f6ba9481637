/** A body of instanced bones and joints. Matrices are written straight from positions; nothing is made per frame. */
import { itemAt, numberAt } from "../lists";
import * as THREE from "three";
import type { Skeleton } from "../motion/body/skeleton";

const LIMB = 0.016; // radius of a bone in body heights
const JOINT = 0.019;
const HEAD = 0.052;
const MARKER = 0.007;
const LINE = 0.003;

/** A bone of length 1 along +Y, slimmer at its end. */
const boneShape = new THREE.CylinderGeometry(0.62, 1, 1, 10, 1).translate(0, 0.5, 0);
const jointShape = new THREE.SphereGeometry(1, 16, 12);

export type Tint = (point: number) => THREE.Color;

export class Body {
  readonly group = new THREE.Group();
  private readonly bones: THREE.InstancedMesh;
  private readonly joints: THREE.InstancedMesh;
  private readonly radius: number;
  private readonly sizes: Float32Array;
  /** The point above the head's joint: the skull is between the two. */
  private readonly crown: number = -1;

  constructor(
    readonly skeleton: Skeleton,
    tint: Tint,
    private readonly opacity = 1,
  ) {
    const edges = skeleton.edges.length / 2;
    const material = new THREE.MeshStandardMaterial({
      roughness: 0.62,
      metalness: 0,
      transparent: opacity < 1,
      opacity,
      depthWrite: opacity === 1,
    });
    this.bones = new THREE.InstancedMesh(boneShape, material, Math.max(1, edges));
    this.joints = new THREE.InstancedMesh(jointShape, material, skeleton.points);
    for (const mesh of [this.bones, this.joints]) {
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      mesh.frustumCulled = false;
      mesh.visible = false;
    }
    this.bones.count = edges;
    // A person of few large bones and one of many small ones look alike.
    this.radius = (skeleton.view.markers ? LINE : LIMB) * skeleton.height;
    this.sizes = new Float32Array(skeleton.points).fill(JOINT * skeleton.height);
    if (skeleton.view.markers) this.sizes.fill(MARKER * skeleton.height);
    const children = new Int32Array(skeleton.points);
    for (let point = 0; point < skeleton.points; point++)
      if (numberAt(skeleton.parents, point) >= 0)
        children[numberAt(skeleton.parents, point)] = numberAt(children, numberAt(skeleton.parents, point)) + 1;
    for (let point = 0; point < skeleton.points; point++) {
      const parent = numberAt(skeleton.parents, point);
      // Fingers and toes are slim: points deep in chains of small bones.
      if (
        !skeleton.view.markers &&
        parent >= 0 &&
        /hand|finger|thumb|toe|index|middle|ring|little|pinky/i.test(this.name(point)) &&
        children[point] === 0
      ) {
        this.sizes[point] = numberAt(this.sizes, point) * 0.55;
      }
    }
    if (skeleton.head >= 0) {
      this.sizes[skeleton.head] = HEAD * skeleton.height;
      this.crown = skeleton.parents.findIndex((parent) => parent === skeleton.head);
      if (this.crown >= 0) this.sizes[this.crown] = 0;
    }
    this.group.add(this.bones, this.joints);
    this.tint(tint);
  }

  private name(point: number): string {
    const bones = this.skeleton.view.bones;
    return point < bones.length
      ? itemAt(bones, point).name
      : itemAt(bones, numberAt(this.skeleton.parents, point)).name;
  }

  tint(tint: Tint): void {
    const { edges, points } = this.skeleton;
    for (let point = 0; point < points; point++) this.joints.setColorAt(point, tint(point));
    for (let edge = 0; edge < edges.length / 2; edge++)
      this.bones.setColorAt(edge, tint(numberAt(edges, edge * 2 + 1)));
    if (this.bones.instanceColor) this.bones.instanceColor.needsUpdate = true;
    if (this.joints.instanceColor) this.joints.instanceColor.needsUpdate = true;
  }

  /** positions: (points, 3) in the clip's unit; NaN hides a point and its bones. */
  pose(positions: Float32Array): void {
    const { edges, points, metres } = this.skeleton;
    const spheres = this.joints.instanceMatrix.array as Float32Array;
    for (let point = 0; point < points; point++) {
      const at = point * 16;
      const x = numberAt(positions, point * 3) * metres;
      const y = numberAt(positions, point * 3 + 1) * metres;
      const z = numberAt(positions, point * 3 + 2) * metres;
      const size = x === x ? numberAt(this.sizes, point) : 0;
      spheres[at] = size;
      spheres[at + 5] = size;
      spheres[at + 10] = size;
      spheres[at + 15] = 1;
      spheres[at + 12] = x === x ? x : 0;
      spheres[at + 13] = x === x ? y : 0;
      spheres[at + 14] = x === x ? z : 0;
    }
    if (this.crown >= 0 && spheres[this.crown * 16 + 15]) {
      const [head, crown] = [this.skeleton.head * 16 + 12, this.crown * 3];
      for (let axis = 0; axis < 3; axis++)
        spheres[head + axis] =
          numberAt(spheres, head + axis) +
          ((numberAt(positions, crown + axis) * metres - numberAt(spheres, head + axis)) * 0.5 || 0);
    }
    const limbs = this.bones.instanceMatrix.array as Float32Array;
    for (let edge = 0; edge < edges.length / 2; edge++) {
      const from = numberAt(edges, edge * 2) * 3;
      const to = numberAt(edges, edge * 2 + 1) * 3;
      const at = edge * 16;
      const ax = numberAt(positions, from) * metres,
        ay = numberAt(positions, from + 1) * metres,
        az = numberAt(positions, from + 2) * metres;
      const dx = numberAt(positions, to) * metres - ax,
        dy = numberAt(positions, to + 1) * metres - ay,
        dz = numberAt(positions, to + 2) * metres - az;
      const length = Math.hypot(dx, dy, dz);
      if (!(length > 1e-9)) {
        limbs.fill(0, at, at + 16);
        limbs[at + 15] = 1;
        continue;
      }
      const radius = Math.min(this.radius, length * 0.22 + this.radius * 0.2);
      const ux = dx / length,
        uy = dy / length,
        uz = dz / length;
      // A perpendicular that does not vanish: across the axis the bone is least along.
      let px: number, py: number, pz: number;
      if (Math.abs(ux) < 0.6) {
        px = 0;
        py = uz;
        pz = -uy;
      } else {
        px = -uz;
        py = 0;
        pz = ux;
      }
      const norm = radius / Math.hypot(px, py, pz);
      px *= norm;
      py *= norm;
      pz *= norm;
      limbs[at] = px;
      limbs[at + 1] = py;
      limbs[at + 2] = pz;
      limbs[at + 3] = 0;
      limbs[at + 4] = dx;
      limbs[at + 5] = dy;
      limbs[at + 6] = dz;
      limbs[at + 7] = 0;
      limbs[at + 8] = py * uz - pz * uy;
      limbs[at + 9] = pz * ux - px * uz;
      limbs[at + 10] = px * uy - py * ux;
      limbs[at + 11] = 0;
      limbs[at + 12] = ax;
      limbs[at + 13] = ay;
      limbs[at + 14] = az;
      limbs[at + 15] = 1;
    }
    this.bones.instanceMatrix.needsUpdate = true;
    this.joints.instanceMatrix.needsUpdate = true;
    this.bones.visible = edges.length > 0;
    this.joints.visible = true;
  }

  hide(): void {
    this.bones.visible = false;
    this.joints.visible = false;
  }

  dispose(): void {
    (this.bones.material as THREE.Material).dispose();
    this.bones.dispose();
    this.joints.dispose();
    this.group.removeFromParent();
  }

  get isGhost(): boolean {
    return this.opacity < 1;
  }
}
