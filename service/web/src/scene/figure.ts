/** A body with a skin, moved by the graphics card. Per frame only the matrices of its joints are written. */
import { itemAt, numberAt } from "../lists";
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
    if (skin.normals) this.geometry.setAttribute("normal", new THREE.BufferAttribute(skin.normals, 3));
    else this.geometry.computeVertexNormals();
    this.tint(tint);
  }

  /** Its own colours; else the colour of the middle, with some of the sides'. */
  tint(tint: Tint): void {
    const colours = this.geometry.getAttribute("color") as THREE.BufferAttribute;
    const given = this.skin.colours;
    if (given) {
      const one = new THREE.Color();
      for (let vertex = 0; vertex < colours.count; vertex++) {
        const [r, g, b] = [0, 1, 2].map((part) => numberAt(given, vertex * 3 + part) / 255) as [number, number, number];
        one.setRGB(r, g, b, THREE.SRGBColorSpace);
        colours.setXYZ(vertex, one.r, one.g, one.b);
      }
      colours.needsUpdate = true;
      return;
    }
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
      // Hair and cloth of characters are sheets, seen from both sides.
      side: shape.skin.own ? THREE.DoubleSide : THREE.FrontSide,
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
    const metres = skin.own?.metres ?? skeleton.metres;
    this.mesh.visible = moveSkin(skin, positions, turns, metres, this.matrices.numbers);
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
    const { own } = skin;
    if (!own) return;
    // From its own axes to the clip's, in which the group around it is, and from where the clip is drawn.
    this.group.rotation.x = ((Number(skeleton.zUp) - Number(own.zUp)) * Math.PI) / 2;
    const [x, y, z] = [0, 1, 2].map((axis) => -numberAt(own.origin, axis) * skeleton.metres) as [
      number,
      number,
      number,
    ];
    this.group.position.set(x, y, z);
  }

  /** Make room for a skin with joints of its own, whose head may be far above those of the clip. box: of the joints,
   * metres in the world. */
  stretch(box: THREE.Box3): void {
    const { own, points } = this.shape.skin;
    if (!own || box.isEmpty()) return;
    let [least, most] = [Infinity, -Infinity];
    for (let at = own.zUp ? 2 : 1; at < points.length; at += 3) {
      least = Math.min(least, numberAt(points, at));
      most = Math.max(most, numberAt(points, at));
    }
    box.max.y = Math.max(box.max.y, box.min.y + Math.max(0, most - least) * own.metres);
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
