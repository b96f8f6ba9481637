/** A body with a skin, moved by the graphics card. Per frame only the matrices of its joints are written. */
import { itemAt } from "../lists";
import * as THREE from "three";
import { leadersOf, moveSkin, type Skin } from "../motion/body/skin";
import type { Skeleton } from "../motion/body/skeleton";
import type { Tint } from "./body";

const TO_SIDE = 0.4; // how much of a side's colour its limbs have
const LEAST_LIGHT = 0.55; // dark inks of a light theme would hide the shape
const BONE = new THREE.Bone();

/** Matrices that are written from outside, not by bones. */
class Matrices extends THREE.Skeleton {
  constructor(joints: number) {
    super(Array.from({ length: joints }, () => BONE));
    this.computeBoneTexture();
  }

  get numbers(): Float32Array {
    return this.texture.image.data as Float32Array;
  }

  override update(): void {
    this.texture.needsUpdate = true;
  }

  private get texture(): THREE.DataTexture {
    if (!this.boneTexture) throw new Error("The matrices have been disposed of.");
    return this.boneTexture;
  }
}

/** The mesh that a body and its ghosts share. */
export class FigureShape {
  readonly geometry = new THREE.BufferGeometry();
  private readonly leaders: Uint16Array;

  constructor(
    readonly skin: Skin,
    readonly skeleton: Skeleton,
    tint: Tint,
  ) {
    this.leaders = leadersOf(skin);
    this.geometry.setAttribute("position", new THREE.BufferAttribute(skin.points, 3));
    this.geometry.setAttribute("skinIndex", new THREE.BufferAttribute(skin.joints, 4));
    this.geometry.setAttribute("skinWeight", new THREE.BufferAttribute(skin.weights, 4));
    this.geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(skin.points.length), 3));
    this.geometry.setIndex(new THREE.BufferAttribute(skin.triangles, 1));
    this.geometry.computeVertexNormals();
    this.tint(tint);
  }

  /** The colour of the middle, with some of the sides'. */
  tint(tint: Tint): void {
    const colours = this.geometry.getAttribute("color") as THREE.BufferAttribute;
    const middle = tint(this.skeleton.sides.indexOf(0));
    const mixed = new THREE.Color();
    const hsl = { h: 0, s: 0, l: 0 };
    this.leaders.forEach((joint, vertex) => {
      mixed.lerpColors(middle, tint(joint), TO_SIDE).getHSL(hsl, THREE.SRGBColorSpace);
      mixed.setHSL(hsl.h, hsl.s, Math.max(hsl.l, LEAST_LIGHT), THREE.SRGBColorSpace);
      colours.setXYZ(vertex, mixed.r, mixed.g, mixed.b);
    });
    colours.needsUpdate = true;
  }
}

export class Figure {
  readonly mesh: THREE.SkinnedMesh;
  private readonly matrices: Matrices;

  constructor(
    private readonly shape: FigureShape,
    opacity = 1,
  ) {
    const material = new THREE.MeshStandardMaterial({
      vertexColors: true,
      roughness: 0.72,
      metalness: 0,
      transparent: opacity < 1,
      opacity,
      depthWrite: opacity === 1,
    });
    this.mesh = new THREE.SkinnedMesh(shape.geometry, material);
    this.matrices = new Matrices(shape.skin.turns.length);
    this.mesh.bindMode = THREE.DetachedBindMode;
    this.mesh.bind(this.matrices, new THREE.Matrix4());
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  /** positions: (points, 3), turns: (joints, 4) from rest. False, and hidden, where a joint that it needs is unknown. */
  pose(positions: Float32Array, turns: Float32Array): boolean {
    const { skin, skeleton } = this.shape;
    this.mesh.visible = moveSkin(skin, positions, turns, skeleton.metres, this.matrices.numbers);
    return this.mesh.visible;
  }

  hide(): void {
    this.mesh.visible = false;
  }

  dispose(): void {
    (this.mesh.material as THREE.Material).dispose();
    this.matrices.dispose();
    this.mesh.removeFromParent();
  }
}

/** The body of an actor and its ghosts. */
export class Figures {
  readonly group = new THREE.Group();
  readonly shape: FigureShape;
  private readonly figures: Figure[];

  /** opacities: of the body, then of each ghost. */
  constructor(skin: Skin, skeleton: Skeleton, tint: Tint, opacities: readonly number[]) {
    this.shape = new FigureShape(skin, skeleton, tint);
    this.figures = opacities.map((opacity) => new Figure(this.shape, opacity));
    this.group.add(...this.figures.map((figure) => figure.mesh));
  }

  /** Pose the body (0) or a ghost. False where it cannot be: positions or rotations are not there. */
  pose(number: number, positions: Float32Array | null, turns: Float32Array | null | undefined): boolean {
    const figure = itemAt(this.figures, number);
    if (positions && turns) return figure.pose(positions, turns);
    figure.hide();
    return false;
  }

  dispose(): void {
    for (const figure of this.figures) figure.dispose();
    this.shape.geometry.dispose();
    this.group.removeFromParent();
  }
}
