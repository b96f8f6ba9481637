/**
 * The stage: bodies on a ground, seen by a camera that is orbited. Takes typed arrays, never fetches. Draws when something
 * changed, and only then. World: metres, Y up. Clips whose up axis is Z are turned by the group they stand in.
 */
import { itemAt, numberAt } from "../lists";
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { actorOf, dispose, dress, pose, recolour, type Actor, type Pose } from "./actor";
import { Ground } from "./ground";
import { arrowAt, drawHandle, pullOf, type Handle, type Surroundings } from "./handle";
import { middleOf } from "../motion/body/middle";
import { drawAxes } from "./axes";
import { cleared, drawJoints, pictureOf } from "./overlay";
import { seeAsFarAs, viewOf, type CameraView } from "./framing";
import { lamps } from "./lamps";
import { isSoftware, Sharpness } from "./sharpness";
import type { Vector } from "../motion/body/quaternions";
import type { Skeleton } from "../motion/body/skeleton";
import type { Skin } from "../motion/body/skin";

export type { CameraView, Pose };
export interface Shown {
  follow: boolean;
  ghosts: boolean;
  trails: boolean;
  names: boolean;
  axes: boolean;
  /** Bodies with a skin instead of bones. */
  body: boolean;
  forces?: boolean;
  rest?: boolean;
}

const PICK_PIXELS = 14;

export class Stage {
  readonly canvas: HTMLCanvasElement;
  readonly overlay: HTMLCanvasElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(38, 1, 0.01, 200);
  private readonly controls: OrbitControls;
  private readonly ground = new Ground();
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0x53606f, 1.5);
  private readonly actors: Actor[] = [];
  private readonly observer: ResizeObserver;
  private pending = 0;
  private gridStep = 0.5;
  private floor = 0;
  private followed = new THREE.Vector3();
  private readonly sharpness: Sharpness;
  private wanted = 0; // when the frame that is pending was requested
  private submitted = 0;
  shown: Shown = { follow: false, ghosts: false, trails: false, names: false, axes: true, body: false };
  selected = new Set<number>();
  hovered = -1;
  /** Arrows that a hand pulls; null: none. */
  handle: Handle | null = null;
  /** Script time of the last frame, ms: matrices, scene and overlay. */
  lastScript = 0;
  onCamera: () => void = () => {};
  /** After each frame. */
  onDrawn: () => void = () => {};
  private unfinished: WebGLSync | null = null;

  constructor(
    private readonly host: HTMLElement,
    private readonly token: (name: string) => string,
  ) {
    this.renderer = new THREE.WebGLRenderer({
      antialias: !isSoftware(),
      alpha: false,
      powerPreference: "high-performance",
    });
    this.renderer.outputColorSpace = THREE.SRGBColorSpace;
    this.sharpness = new Sharpness(this.renderer, () => {
      if (!document.hidden) this.draw();
    });
    this.canvas = this.renderer.domElement;
    this.overlay = document.createElement("canvas");
    this.overlay.className = "stage-overlay";
    this.canvas.className = "stage-canvas";
    host.append(this.canvas, this.overlay);
    this.scene.add(this.ground.mesh);
    this.scene.add(this.sky, ...lamps());
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.camera.position.set(3, 2, 4);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => {
      this.ask();
      this.onCamera();
    });
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.recolour();
    this.resize();
  }

  /** Put a skeleton on the stage. shift: metres to the side of the others. ink: a token that colours all of it. */
  add(skeleton: Skeleton, options: { shift?: number; dim?: boolean; ink?: string | null } = {}): number {
    const made = actorOf(skeleton, this.token, options);
    this.scene.add(made.group);
    this.actors.push(made);
    this.ask();
    return this.actors.length - 1;
  }

  clear(): void {
    for (const actor of this.actors.splice(0)) dispose(actor);
    this.ask();
  }

  pose(actor: number, next: Pose): void {
    const one = this.actors[actor];
    if (!one) return;
    pose(one, next);
    this.ask();
  }

  /** Put a skin on an actor; null: bones again. Poses tell rotations then. */
  dress(actor: number, skin: Skin | null): void {
    dress(itemAt(this.actors, actor), skin, this.token);
  }

  /** Where the ground is: the height of the lowest pose seen, metres in the world. */
  setFloor(height: number, step: number): void {
    this.floor = height;
    this.gridStep = step;
    this.ask();
  }

  get floorHeight(): number {
    return this.floor;
  }

  /** Look at what stands there. Whether anything does. */
  frame(view: CameraView = "persp", only: number[] = []): boolean {
    const box = new THREE.Box3();
    for (const actor of this.actors) {
      if (!actor.positions) continue;
      const points = only.length ? only : [...Array(actor.skeleton.points).keys()];
      for (const point of points) {
        const at = this.world(actor, point);
        if (at) box.expandByPoint(at);
      }
      if (!only.length) actor.figures?.stretch(box);
    }
    if (box.isEmpty()) return false;
    if (only.length) box.expandByScalar(0.25);
    const middle = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const { direction, away } = viewOf(size, this.camera, view);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(direction, away);
    this.letFar(away);
    this.followed.copy(this.root() ?? middle);
    this.controls.update();
    this.ask();
    return true;
  }

  /** Let the camera see what is so far away, and go nearer and farther. */
  private letFar(away: number): void {
    seeAsFarAs(this.camera, away);
    this.controls.minDistance = Math.min(0.1, away / 20);
    this.controls.maxDistance = Math.max(60, away * 10);
  }

  /** The camera as text for an address: position and target, millimetres. */
  get cameraText(): string {
    const { position } = this.camera;
    const { target } = this.controls;
    return [...position.toArray(), ...target.toArray()].map((one) => Math.round(one * 1000)).join(",");
  }

  set cameraText(text: string) {
    const numbers = text.split(",").map((one) => Number(one) / 1000);
    if (numbers.length !== 6 || numbers.some(Number.isNaN)) return;
    this.camera.position.fromArray(numbers, 0);
    this.controls.target.fromArray(numbers, 3);
    const away = this.camera.position.distanceTo(this.controls.target);
    this.letFar(away);
    this.followed.copy(this.root() ?? this.controls.target);
    this.controls.update();
  }

  /** The joint under a place on the canvas: (actor, point), or null. */
  pick(x: number, y: number): { actor: number; point: number } | null {
    let best: { actor: number; point: number } | null = null;
    let least = PICK_PIXELS ** 2;
    this.actors.forEach((actor, index) => {
      if (!actor.positions || actor.dim) return;
      for (let point = 0; point < actor.skeleton.view.bones.length; point++) {
        const at = this.onScreen(actor, point);
        if (!at) continue;
        const away = (at.x - x) ** 2 + (at.y - y) ** 2;
        if (away < least) [least, best] = [away, { actor: index, point }];
      }
    });
    return best;
  }

  recolour(): void {
    const well = new THREE.Color(this.token("well"));
    this.renderer.setClearColor(well);
    // Dark inks on a light ground need more light to be seen as colours.
    this.sky.intensity = well.getHSL({ h: 0, s: 0, l: 0 }).l > 0.5 ? 3.4 : 1.5;
    this.ground.ink(this.token("edge"));
    for (const actor of this.actors) recolour(actor, this.token);
    this.ask();
  }

  /** Draw soon. */
  ask(): void {
    if (this.pending || document.hidden) return;
    this.wanted = performance.now();
    this.pending = requestAnimationFrame(this.turn);
  }

  /** Draws, unless the frame before is not done: frames that queue let the hand wait. */
  private readonly turn = (): void => {
    this.pending = 0;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (
      this.unfinished &&
      !gl.isContextLost() &&
      gl.getSyncParameter(this.unfinished, gl.SYNC_STATUS) !== gl.SIGNALED
    ) {
      this.pending = requestAnimationFrame(this.turn);
      return;
    }
    gl.deleteSync(this.unfinished);
    const now = performance.now();
    this.sharpness.move(now - Math.max(this.wanted, this.submitted));
    this.submitted = now;
    this.draw();
    this.unfinished = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.onDrawn();
  };

  private draw(): void {
    this.pending = 0;
    const started = performance.now();
    const root = this.root();
    if (this.shown.follow && root) {
      const moved = root.clone().sub(this.followed);
      moved.y = 0;
      if (moved.lengthSq() > 1e-12) {
        this.camera.position.add(moved);
        this.controls.target.add(moved);
        this.followed.copy(root);
      }
    } else if (root) this.followed.copy(root);
    const reach = Math.max(4, this.camera.position.distanceTo(this.controls.target) * 2.6);
    this.ground.thick = this.sharpness.larger;
    this.ground.place(this.controls.target, this.floor, this.gridStep, reach);
    this.camera.lookAt(this.controls.target);
    this.renderer.render(this.scene, this.camera);
    this.drawOverlay();
    this.lastScript = performance.now() - started;
  }

  /** What the camera follows: the middle of all joints, as the first one of many rigs stands at the origin while the body walks. */
  private root(): THREE.Vector3 | null {
    const actor = this.actors.find((one) => one.positions);
    const middle = actor && middleOf(actor.positions!, actor.skeleton.view.bones.length);
    return middle ? this.placed(actor, middle) : null;
  }

  private world(actor: Actor, point: number): THREE.Vector3 | null {
    const { positions } = actor;
    if (!positions || positions[point * 3] !== positions[point * 3]) return null;
    return this.placed(actor, [
      numberAt(positions, point * 3),
      numberAt(positions, point * 3 + 1),
      numberAt(positions, point * 3 + 2),
    ]);
  }

  /** A place of an actor, in its own unit and axes, in the world. */
  private placed({ skeleton, shift }: Actor, at: readonly [number, number, number]): THREE.Vector3 {
    const [x, y, z] = at;
    const turned = skeleton.zUp ? new THREE.Vector3(x, z, -y) : new THREE.Vector3(x, y, z);
    return turned.multiplyScalar(skeleton.metres).add(shift);
  }

  private around(handle: Handle): Surroundings {
    const actor = itemAt(this.actors, handle.actor);
    return {
      world: (at) => this.placed(actor, at),
      screen: (at) => this.projected(at),
      camera: this.camera,
      zUp: actor.skeleton.zUp,
      metres: actor.skeleton.metres,
      length: 0.13 * actor.skeleton.height,
    };
  }

  /** The arrow of the handle under a place on the canvas. */
  arrowAt(x: number, y: number): string | null {
    return this.handle && arrowAt(this.handle, this.around(this.handle), x, y);
  }

  /** How far a place on the canvas pulls one of a handle's arrows, in the actor's unit and axes. */
  pullOf(handle: Handle, name: string, x: number, y: number): Vector {
    return pullOf(handle, this.around(handle), name, x, y, this.host.clientWidth, this.host.clientHeight);
  }

  /** Whether the hand turns the camera; not while it pulls an arrow. */
  set orbits(on: boolean) {
    this.controls.enabled = on;
  }

  /** Whether all of an actor is in the picture. */
  sees(actor: number): boolean {
    const one = itemAt(this.actors, actor);
    return [...Array(one.skeleton.points).keys()].every((point) => {
      const at = this.onScreen(one, point);
      return at && at.x >= 0 && at.y >= 0 && at.x <= this.host.clientWidth && at.y <= this.host.clientHeight;
    });
  }

  private onScreen(actor: Actor, point: number): { x: number; y: number } | null {
    const at = this.world(actor, point);
    return at && this.projected(at);
  }

  private projected(world: THREE.Vector3): { x: number; y: number } | null {
    const at = world.project(this.camera);
    if (at.z > 1) return null;
    return { x: ((at.x + 1) / 2) * this.host.clientWidth, y: ((1 - at.y) / 2) * this.host.clientHeight };
  }

  private drawOverlay(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    const pen = cleared(this.overlay, width, height);
    const actor = this.actors.find((one) => !one.dim);
    if (actor?.positions) {
      pen.font = `12px ${getComputedStyle(this.host).fontFamily}`;
      const marked = { names: this.shown.names, selected: this.selected, hovered: this.hovered };
      drawJoints(pen, actor.skeleton, marked, (point) => this.onScreen(actor, point), this.token);
    }
    if (this.handle) drawHandle(pen, this.handle, this.around(this.handle), this.token);
    if (this.shown.axes) drawAxes(pen, this.camera, this.token, width - 40, height - 40, actor?.skeleton.zUp ?? false);
  }

  /** Colour all of an actor by a token; null: by its sides. */
  paint(actor: number, ink: string | null): void {
    if (itemAt(this.actors, actor).ink === ink) return;
    itemAt(this.actors, actor).ink = ink;
    this.recolour();
  }

  /** Put an actor elsewhere: metres in the world. */
  place(actor: number, x: number, y: number, z: number): void {
    itemAt(this.actors, actor).shift.set(x, y, z);
    itemAt(this.actors, actor).group.position.set(x, y, z);
  }

  private resize(): void {
    const [width, height] = [Math.max(1, this.host.clientWidth), Math.max(1, this.host.clientHeight)];
    const ratio = Math.min(devicePixelRatio, 2);
    this.sharpness.screen = ratio;
    this.renderer.setSize(width, height, false);
    this.overlay.width = width * ratio;
    this.overlay.height = height * ratio;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // At once: a canvas that was resized is empty until it is drawn.
    cancelAnimationFrame(this.pending);
    this.draw();
  }

  /** The picture as it is now. */
  picture(): Promise<Blob> {
    this.sharpness.rest();
    this.draw();
    return pictureOf(this.canvas, this.overlay);
  }

  get drawCalls(): number {
    return this.renderer.info.render.calls;
  }

  close(): void {
    cancelAnimationFrame(this.pending);
    this.sharpness.close();
    this.pending = -1;
    this.clear();
    this.observer.disconnect();
    this.controls.dispose();
    this.ground.mesh.geometry.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
    this.overlay.remove();
  }
}
