/** The ground: a grid in real units, drawn by a shader so that lines stay a pixel wide and fade far away. */
import * as THREE from "three";

const VERTEX = `
varying vec3 place;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  place = world.xyz;
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const FRAGMENT = `
varying vec3 place;
uniform vec3 ink;
uniform vec3 centre;
uniform float step_;
uniform float reach;
uniform float thick;
float lines(vec2 at, float size) {
  vec2 here = at / size;
  vec2 wide = fwidth(here);
  vec2 near = abs(fract(here - 0.5) - 0.5) / (wide * thick);
  float found = 1.0 - min(min(near.x, near.y), 1.0);
  return found * clamp(1.0 - max(wide.x, wide.y) * 1.6, 0.0, 1.0);
}
void main() {
  float away = distance(place, centre) / reach;
  float fade = pow(clamp(1.0 - away, 0.0, 1.0), 1.4);
  float shown = max(lines(place.xz, step_) * 0.42, lines(place.xz, step_ * 4.0) * 0.85);
  gl_FragColor = vec4(ink, shown * fade);
}`;

export class Ground {
  readonly mesh: THREE.Mesh;
  private readonly uniforms = {
    ink: { value: new THREE.Color() },
    centre: { value: new THREE.Vector3() },
    step_: { value: 0.5 },
    reach: { value: 8 },
    thick: { value: 1 },
  };

  constructor() {
    const material = new THREE.ShaderMaterial({
      uniforms: this.uniforms,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      transparent: true,
      side: THREE.DoubleSide,
      depthWrite: false,
    });
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -1;
  }

  /** Pixels that a line is wide. */
  set thick(pixels: number) {
    this.uniforms.thick.value = Math.max(1, pixels);
  }

  /** height, step: metres. */
  place(centre: THREE.Vector3, height: number, step: number, reach: number): void {
    this.mesh.position.set(centre.x, height, centre.z);
    this.mesh.scale.set(reach * 2, 1, reach * 2);
    this.uniforms.centre.value.set(centre.x, height, centre.z);
    this.uniforms.step_.value = step;
    this.uniforms.reach.value = reach;
  }

  ink(colour: string): void {
    this.uniforms.ink.value.set(colour);
  }
}
