/**
 * The stage: bodies on a ground, seen by a camera that is orbited. The only part that knows three.js; takes typed arrays,
 * never fetches. Draws when something changed, and only then.
 *
 * World: metres, Y up. Clips whose up axis is Z are turned by the group they stand in.
 */
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Body, type Tint } from "./body";
import { Ground } from "./ground";
import { SIDE_TOKENS, type Skeleton } from "../motion/skeleton";

export type CameraView = "persp" | "front" | "side" | "top";
export interface Shown { follow: boolean; ghosts: boolean; trails: boolean; names: boolean; axes: boolean }

export interface Pose { positions: Float32Array | null; before: (Float32Array | null)[]; trail: Float32Array[] }

interface Actor {
  skeleton: Skeleton;
  group: THREE.Group;
  body: Body;
  ghosts: Body[];
  trails: THREE.LineSegments;
  trailRoom: number;
  shift: THREE.Vector3;
  positions: Float32Array | null;
  dim: boolean;
}

const TRAIL_POINTS = 4096;
const GHOST_OPACITY = 0.16;
const PICK_PIXELS = 14;
const MOST_NAMED = 4; // of joints that are selected: more names would cover one another

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
  private slow = 0;
  shown: Shown = { follow: false, ghosts: false, trails: false, names: false, axes: true };
  selected = new Set<number>();
  hovered = -1;
  /** Script time of the last frame, ms: matrices, scene and overlay. */
  lastScript = 0;
  onCamera: () => void = () => {};

  constructor(private readonly host: HTMLElement, private readonly token: (name: string) => string) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: false, powerPreference: "high-performance" });
    this.renderer.outputColorSpace = THREE.SRGBColorSpace;
    this.canvas = this.renderer.domElement;
    this.overlay = document.createElement("canvas");
    this.overlay.className = "stage-overlay";
    this.canvas.className = "stage-canvas";
    host.append(this.canvas, this.overlay);
    this.scene.add(this.ground.mesh);
    const sky = this.sky;
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(1.5, 4, 2.5);
    const back = new THREE.DirectionalLight(0xffffff, 0.5);
    back.position.set(-2, 2, -3);
    this.scene.add(sky, sun, back);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.maxDistance = 60;
    this.controls.minDistance = 0.1;
    this.controls.addEventListener("change", () => {
      this.ask();
      this.onCamera();
    });
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.recolour();
    this.resize();
  }

  /** Put a skeleton on the stage. shift: metres to the side of the others. */
  add(skeleton: Skeleton, { shift = 0, dim = false }: { shift?: number; dim?: boolean } = {}): number {
    const group = new THREE.Group();
    if (skeleton.zUp) group.rotation.x = -Math.PI / 2;
    const body = new Body(skeleton, this.tintOf(skeleton), dim ? 0.45 : 1);
    const ghosts = [0, 1, 2, 3].map(() => new Body(skeleton, this.tintOf(skeleton), GHOST_OPACITY));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(TRAIL_POINTS * 6), 3).setUsage(THREE.DynamicDrawUsage));
    geometry.setDrawRange(0, 0);
    const trails = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: this.token("accent"), transparent: true, opacity: 0.75 }));
    trails.frustumCulled = false;
    group.add(body.group, trails, ...ghosts.map((ghost) => ghost.group));
    const outer = new THREE.Vector3(shift, 0, 0);
    group.position.copy(outer);
    this.scene.add(group);
    this.actors.push({ skeleton, group, body, ghosts, trails, trailRoom: TRAIL_POINTS, shift: outer, positions: null, dim });
    this.ask();
    return this.actors.length - 1;
  }

  clear(): void {
    for (const actor of this.actors.splice(0)) {
      actor.body.dispose();
      for (const ghost of actor.ghosts) ghost.dispose();
      actor.trails.geometry.dispose();
      (actor.trails.material as THREE.Material).dispose();
      actor.group.removeFromParent();
    }
    this.ask();
  }

  pose(actor: number, pose: Pose): void {
    const one = this.actors[actor];
    if (!one) return;
    one.positions = pose.positions;
    if (pose.positions) one.body.pose(pose.positions);
    else one.body.hide();
    one.ghosts.forEach((ghost, place) => {
      const positions = pose.before[place];
      if (positions) ghost.pose(positions);
      else ghost.hide();
    });
    this.trail(one, pose.trail);
    this.ask();
  }

  private trail(actor: Actor, lines: Float32Array[]): void {
    const attribute = actor.trails.geometry.getAttribute("position") as THREE.BufferAttribute;
    const room = attribute.array as Float32Array;
    const metres = actor.skeleton.metres;
    let used = 0;
    for (const line of lines) {
      for (let at = 0; at + 5 < line.length && used + 6 <= room.length; at += 3) {
        for (let axis = 0; axis < 6; axis++) room[used + axis] = line[at + axis] * metres;
        if (room[used] === room[used] && room[used + 3] === room[used + 3]) used += 6;
      }
    }
    actor.trails.geometry.setDrawRange(0, used / 3);
    attribute.needsUpdate = true;
    actor.trails.visible = used > 0;
  }

  /** Where the ground is: the height of the lowest pose seen, metres in the world. */
  setFloor(height: number, step: number): void {
    this.floor = height;
    this.gridStep = step;
    this.ask();
  }

  get grid(): number {
    return this.gridStep;
  }

  /** Look at what stands there. */
  frame(view: CameraView = "persp", only: number[] = []): void {
    const box = new THREE.Box3();
    for (const actor of this.actors) {
      if (!actor.positions) continue;
      const points = only.length ? only : [...Array(actor.skeleton.points).keys()];
      for (const point of points) {
        const at = this.world(actor, point);
        if (at) box.expandByPoint(at);
      }
    }
    if (box.isEmpty()) return;
    if (only.length) box.expandByScalar(0.25);
    const middle = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const fov = (this.camera.fov * Math.PI) / 360;
    const tall = size.y / 2 / Math.tan(fov);
    const wide = Math.hypot(size.x, size.z) / 2 / (Math.tan(fov) * this.camera.aspect);
    const away = Math.max(tall, wide, 0.2) * 1.35 + Math.max(size.x, size.z) / 2;
    const from = { persp: [0.62, 0.28, 1], front: [0, 0, 1], side: [1, 0, 0], top: [0, 1, 0.0001] }[view];
    const direction = new THREE.Vector3(...from).normalize();
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(direction, away);
    this.camera.near = away / 100;
    this.camera.far = away * 60;
    this.camera.updateProjectionMatrix();
    this.followed.copy(this.root() ?? middle);
    this.controls.update();
    this.ask();
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
    this.camera.near = away / 100;
    this.camera.far = away * 60;
    this.camera.updateProjectionMatrix();
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
    for (const actor of this.actors) {
      actor.body.tint(this.tintOf(actor.skeleton));
      for (const ghost of actor.ghosts) ghost.tint(this.tintOf(actor.skeleton));
      (actor.trails.material as THREE.LineBasicMaterial).color.set(this.token("accent"));
    }
    this.ask();
  }

  /** Draw soon. */
  ask(): void {
    if (!this.pending && !document.hidden) this.pending = requestAnimationFrame(() => this.draw());
  }

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
    this.ground.place(this.controls.target, this.floor, this.gridStep, reach);
    this.camera.lookAt(this.controls.target);
    this.renderer.render(this.scene, this.camera);
    this.drawOverlay();
    this.lastScript = performance.now() - started;
    this.slow = this.lastScript > 12 ? this.slow + 1 : 0;
    if (this.slow > 30 && this.renderer.getPixelRatio() > 1) {
      this.renderer.setPixelRatio(1);
      this.slow = 0;
    }
  }

  private root(): THREE.Vector3 | null {
    const actor = this.actors.find((one) => one.positions);
    return actor ? this.world(actor, 0) : null;
  }

  private world(actor: Actor, point: number): THREE.Vector3 | null {
    const { positions, skeleton, shift } = actor;
    if (!positions) return null;
    const [x, y, z] = [0, 1, 2].map((axis) => positions[point * 3 + axis] * skeleton.metres);
    if (x !== x) return null;
    return (skeleton.zUp ? new THREE.Vector3(x, z, -y) : new THREE.Vector3(x, y, z)).add(shift);
  }

  private onScreen(actor: Actor, point: number): { x: number; y: number } | null {
    const at = this.world(actor, point)?.project(this.camera);
    if (!at || at.z > 1) return null;
    return { x: ((at.x + 1) / 2) * this.host.clientWidth, y: ((1 - at.y) / 2) * this.host.clientHeight };
  }

  private drawOverlay(): void {
    const pen = this.overlay.getContext("2d")!;
    const ratio = this.overlay.width / Math.max(1, this.host.clientWidth);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, this.host.clientWidth, this.host.clientHeight);
    const actor = this.actors.find((one) => !one.dim);
    if (actor?.positions) {
      pen.font = `12px ${getComputedStyle(this.host).fontFamily}`;
      pen.textBaseline = "middle";
      actor.skeleton.view.bones.forEach((bone, point) => {
        const chosen = this.selected.has(point);
        if (!this.shown.names && !chosen && point !== this.hovered) return;
        const at = this.onScreen(actor, point);
        if (!at) return;
        if (chosen || point === this.hovered) {
          pen.lineWidth = 2;
          pen.strokeStyle = this.token(chosen ? "select" : "accent");
          pen.beginPath();
          pen.arc(at.x, at.y, 9, 0, Math.PI * 2);
          pen.stroke();
        }
        if (!this.shown.names && point !== this.hovered && this.selected.size > MOST_NAMED) return;
        pen.lineWidth = 3;
        pen.strokeStyle = this.token("well");
        pen.strokeText(bone.name, at.x + 14, at.y);
        pen.fillStyle = this.token(chosen ? "select" : "text2");
        pen.fillText(bone.name, at.x + 14, at.y);
      });
    }
    if (this.shown.axes) this.drawAxes(pen, actor?.skeleton.zUp ?? false);
  }

  private drawAxes(pen: CanvasRenderingContext2D, zUp: boolean): void {
    const [x0, y0] = [this.host.clientWidth - 40, this.host.clientHeight - 40];
    const axes: [string, THREE.Vector3][] = zUp
      ? [["x", new THREE.Vector3(1, 0, 0)], ["y", new THREE.Vector3(0, 0, -1)], ["z", new THREE.Vector3(0, 1, 0)]]
      : [["x", new THREE.Vector3(1, 0, 0)], ["y", new THREE.Vector3(0, 1, 0)], ["z", new THREE.Vector3(0, 0, 1)]];
    pen.textAlign = "center";
    for (const [name, axis] of axes.sort((a, b) => depth(b[1], this.camera) - depth(a[1], this.camera))) {
      const seen = axis.clone().transformDirection(this.camera.matrixWorldInverse);
      const [x, y] = [x0 + seen.x * 20, y0 - seen.y * 20];
      pen.strokeStyle = pen.fillStyle = this.token(name);
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(x0, y0);
      pen.lineTo(x, y);
      pen.stroke();
      pen.fillText(name.toUpperCase(), x0 + seen.x * 30, y0 - seen.y * 30);
    }
    pen.textAlign = "start";
  }

  private tintOf(skeleton: Skeleton): Tint {
    const colours = SIDE_TOKENS.map((name) => new THREE.Color(this.token(name)));
    return (point) => colours[skeleton.sides[point]];
  }

  private resize(): void {
    const [width, height] = [Math.max(1, this.host.clientWidth), Math.max(1, this.host.clientHeight)];
    const ratio = Math.min(devicePixelRatio, 2);
    this.renderer.setPixelRatio(ratio);
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
    this.draw();
    const both = document.createElement("canvas");
    both.width = this.canvas.width;
    both.height = this.canvas.height;
    const pen = both.getContext("2d")!;
    pen.drawImage(this.canvas, 0, 0);
    pen.drawImage(this.overlay, 0, 0, both.width, both.height);
    return new Promise((resolve) => both.toBlob((blob) => resolve(blob!), "image/png"));
  }

  get drawCalls(): number {
    return this.renderer.info.render.calls;
  }

  close(): void {
    cancelAnimationFrame(this.pending);
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

const depth = (axis: THREE.Vector3, camera: THREE.Camera): number =>
  -axis.clone().transformDirection(camera.matrixWorldInverse).z;
