/** A face of markers in the round: dots, a surface between them, or a mesh that follows them. */
import { numberAt } from "../lists";
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { bind, fitted, follow, surfaceOf, type Binding, type Facing } from "../motion/faces/faces";

export type Skin = "markers" | "surface" | "mesh";

const ROOM = 1.0; // of the window that the face leaves free

export class FaceStage {
  private readonly renderer = new THREE.WebGLRenderer({ antialias: true });
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(28, 1, 1, 10_000);
  private readonly controls: OrbitControls;
  private readonly dots: THREE.InstancedMesh;
  private readonly surface: THREE.Mesh;
  private mesh: { shape: THREE.Mesh; binding: Binding } | null = null;
  private readonly observer: ResizeObserver;
  private pending = 0;
  private readonly spot = new THREE.Matrix4();
  private readonly extent: number;
  private skin: Skin = "surface";

  /** neutral: (markers, 3) the face at rest, NaN where a marker is missing. Error where there is no WebGL. */
  constructor(
    private readonly host: HTMLElement,
    private readonly neutral: Float32Array,
    private readonly facing: Facing,
    private readonly token: (name: string) => string,
  ) {
    host.append(this.renderer.domElement);
    this.renderer.domElement.className = "stage-canvas";
    const box = new THREE.Box3();
    const at = new THREE.Vector3();
    for (let marker = 0; marker < neutral.length; marker += 3)
      if (neutral[marker] === neutral[marker]) box.expandByPoint(at.fromArray(neutral, marker));
    this.extent = box.getSize(new THREE.Vector3()).length() || 1;
    this.dots = new THREE.InstancedMesh(
      new THREE.SphereGeometry(this.extent / 110, 10, 8),
      new THREE.MeshStandardMaterial({ roughness: 0.6 }),
      neutral.length / 3,
    );
    this.dots.frustumCulled = false;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(neutral.slice(), 3).setUsage(THREE.DynamicDrawUsage));
    geometry.setIndex(new THREE.BufferAttribute(surfaceOf(facing, neutral), 1));
    this.surface = new THREE.Mesh(geometry, skinMaterial());
    this.surface.frustumCulled = false;
    const light = new THREE.DirectionalLight(0xffffff, 2.2);
    const vector = (of: ArrayLike<number>) => new THREE.Vector3().fromArray(of);
    const [right, up, out] = [vector(facing.right), vector(facing.up), vector(facing.out)];
    light.position.copy(out).addScaledVector(up, 0.9).addScaledVector(right, -0.7);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a94a2, 2.2), light, this.dots, this.surface);
    const middle = box.getCenter(new THREE.Vector3());
    this.camera.up.copy(up);
    this.camera.position
      .copy(middle)
      .addScaledVector(out, (this.extent * ROOM) / 2 / Math.tan((this.camera.fov * Math.PI) / 360));
    this.camera.near = this.extent / 50;
    this.camera.far = this.extent * 20;
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.copy(middle);
    this.controls.enablePan = false;
    this.controls.minDistance = this.extent / 2;
    this.controls.maxDistance = this.extent * 6;
    this.controls.addEventListener("change", () => this.ask());
    this.controls.update();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.recolour();
    this.resize();
    this.pose(neutral);
  }

  /** Show a face: (markers, 3), NaN where a marker is missing. */
  pose(markers: Float32Array): void {
    const room = this.surface.geometry.getAttribute("position") as THREE.BufferAttribute;
    const array = room.array as Float32Array;
    for (let marker = 0; marker < markers.length / 3; marker++) {
      const seen = markers[marker * 3] === markers[marker * 3];
      for (let axis = 0; axis < 3; axis++)
        array[marker * 3 + axis] = seen
          ? numberAt(markers, marker * 3 + axis)
          : numberAt(this.neutral, marker * 3 + axis);
      if (seen)
        this.spot.makeTranslation(
          numberAt(markers, marker * 3),
          numberAt(markers, marker * 3 + 1),
          numberAt(markers, marker * 3 + 2),
        );
      else this.spot.makeScale(0, 0, 0);
      this.dots.setMatrixAt(marker, this.spot);
    }
    this.dots.instanceMatrix.needsUpdate = true;
    if (this.skin === "surface") {
      room.needsUpdate = true;
      this.surface.geometry.computeVertexNormals();
    }
    if (this.skin === "mesh" && this.mesh) {
      const place = this.mesh.shape.geometry.getAttribute("position") as THREE.BufferAttribute;
      follow(this.mesh.binding, this.neutral, markers, place.array as Float32Array);
      place.needsUpdate = true;
      this.mesh.shape.geometry.computeVertexNormals();
    }
    this.ask();
  }

  wear(skin: Skin): void {
    this.skin = skin;
    this.surface.visible = skin === "surface";
    if (this.mesh) this.mesh.shape.visible = skin === "mesh";
    this.ask();
  }

  /** A mesh from a file, OBJ or GLB, brought to the size of the face and bound to its markers. Error for what is none. */
  async bindMesh(name: string, content: ArrayBuffer): Promise<void> {
    const geometry = await readMesh(name, content);
    const place = geometry.getAttribute("position");
    const vertices = fitted(
      Float32Array.from({ length: place.count * 3 }, (_, at) => place.getComponent(Math.floor(at / 3), at % 3)),
      this.neutral,
      this.facing,
    );
    const made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.BufferAttribute(vertices.slice(), 3).setUsage(THREE.DynamicDrawUsage));
    if (geometry.index) made.setIndex(geometry.index);
    made.computeVertexNormals();
    this.dropMesh();
    const shape = new THREE.Mesh(made, skinMaterial());
    shape.frustumCulled = false;
    this.scene.add(shape);
    this.mesh = { shape, binding: bind(vertices, this.neutral) };
    this.recolour();
    this.wear("mesh");
  }

  private dropMesh(): void {
    this.mesh?.shape.removeFromParent();
    this.mesh?.shape.geometry.dispose();
    this.mesh = null;
  }

  recolour(): void {
    this.renderer.setClearColor(new THREE.Color(this.token("well")));
    (this.dots.material as THREE.MeshStandardMaterial).color.set(this.token("accent"));
    for (const shape of [this.surface, this.mesh?.shape])
      (shape?.material as THREE.MeshStandardMaterial | undefined)?.color.set(this.token("edge"));
    this.ask();
  }

  private resize(): void {
    const [width, height] = [Math.max(1, this.host.clientWidth), Math.max(1, this.host.clientHeight)];
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  private ask(): void {
    if (!this.pending && !document.hidden)
      this.pending = requestAnimationFrame(() => {
        this.pending = 0;
        this.renderer.render(this.scene, this.camera);
      });
  }

  close(): void {
    cancelAnimationFrame(this.pending);
    this.observer.disconnect();
    this.controls.dispose();
    this.dropMesh();
    this.dots.dispose();
    this.surface.geometry.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }
}

const skinMaterial = () =>
  new THREE.MeshStandardMaterial({ roughness: 0.75, side: THREE.DoubleSide, flatShading: false });

/** The first mesh of a file; all of an OBJ's. */
async function readMesh(name: string, content: ArrayBuffer): Promise<THREE.BufferGeometry> {
  let found: THREE.Object3D;
  if (/\.obj$/i.test(name)) {
    const { OBJLoader } = await import("three/addons/loaders/OBJLoader.js");
    found = new OBJLoader().parse(new TextDecoder().decode(content));
  } else {
    const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
    found = (await new GLTFLoader().parseAsync(content, "")).scene;
  }
  found.updateMatrixWorld(true);
  let largest: THREE.Mesh | null = null;
  found.traverse((one) => {
    const mesh = one as THREE.Mesh;
    if (
      mesh.isMesh &&
      (!largest || mesh.geometry.getAttribute("position").count > largest.geometry.getAttribute("position").count)
    )
      largest = mesh;
  });
  if (!largest) throw new Error(`${name}: no mesh`);
  const mesh = largest as THREE.Mesh;
  return mesh.geometry.clone().applyMatrix4(mesh.matrixWorld);
}
