/** Arrows at a point that a hand pulls, each along its own line, and the point itself, which moves across the picture.
 * Drawn flat over the scene, so that nothing hides them. */
import { numberAt } from "../lists";
import * as THREE from "three";
import type { Vector } from "../motion/body/quaternions";

export interface Arrow {
  name: string;
  /** Of length 1, in the actor's axes. */
  direction: readonly [number, number, number];
  /** The colour's token. */
  token: string;
  /** Times the usual length; a longer one ends in a knob. */
  reach: number;
}

export interface Handle {
  actor: number;
  /** In the actor's unit and axes. */
  at: readonly [number, number, number];
  arrows: Arrow[];
  /** Whether the point itself can be pulled, as the arrow `FREE`. */
  free?: boolean;
  held: string | null;
  /** What stands beside it. */
  words: string;
}

export const FREE = "free";

/** Arrows along the axes of the actor, called X, Y and Z. */
export const axisArrows = (): Arrow[] =>
  ["X", "Y", "Z"].map((name, axis) => ({
    name,
    direction: [0, 1, 2].map((one) => Number(one === axis)) as Vector,
    token: name.toLowerCase(),
    reach: 1,
  }));

/** The scene that a handle is in: places of the actor in the world (metres) and on the screen. */
export interface Surroundings {
  world: (at: readonly [number, number, number]) => THREE.Vector3;
  screen: (world: THREE.Vector3) => { x: number; y: number } | null;
  camera: THREE.PerspectiveCamera;
  /** Whether the actor's Z points up. */
  zUp: boolean;
  /** Metres of one unit of the actor. */
  metres: number;
  /** Of an arrow of reach 1, metres. */
  length: number;
}

const NEAR = 11; // px
const HEAD = 7;
const RING = 8;

function linesOf(handle: Handle, around: Surroundings) {
  const from = around.screen(around.world(handle.at));
  return handle.arrows.flatMap((arrow) => {
    const by = (arrow.reach * around.length) / around.metres;
    const to = around.screen(
      around.world(
        [0, 1, 2].map((axis) => numberAt(handle.at, axis) + numberAt(arrow.direction, axis) * by) as [
          number,
          number,
          number,
        ],
      ),
    );
    return from && to ? [{ arrow, from, to }] : [];
  });
}

export function drawHandle(
  pen: CanvasRenderingContext2D,
  handle: Handle,
  around: Surroundings,
  token: (name: string) => string,
): void {
  const font = pen.font;
  for (const { arrow, from, to } of linesOf(handle, around)) {
    const knob = arrow.reach > 1;
    const long = Math.hypot(to.x - from.x, to.y - from.y) || 1;
    const [ux, uy] = [(to.x - from.x) / long, (to.y - from.y) / long];
    for (const [ink, wide] of [
      [token("well"), 6],
      [token(arrow.token), handle.held === arrow.name ? 4 : 2.5],
    ] as const) {
      pen.strokeStyle = pen.fillStyle = ink;
      pen.lineWidth = wide;
      pen.setLineDash(knob ? [4, 4] : []);
      pen.beginPath();
      pen.moveTo(from.x, from.y);
      pen.lineTo(to.x, to.y);
      pen.stroke();
      pen.setLineDash([]);
    }
    pen.beginPath();
    if (knob) pen.arc(to.x, to.y, 6, 0, Math.PI * 2);
    else {
      pen.moveTo(to.x + ux * HEAD, to.y + uy * HEAD);
      pen.lineTo(to.x - uy * HEAD * 0.7, to.y + ux * HEAD * 0.7);
      pen.lineTo(to.x + uy * HEAD * 0.7, to.y - ux * HEAD * 0.7);
    }
    pen.fill();
    if (knob) continue;
    pen.font = `600 ${font}`;
    pen.textAlign = "center";
    pen.fillText(arrow.name, to.x + ux * 18, to.y + uy * 18);
    pen.textAlign = "start";
    pen.font = font;
  }
  const at = around.screen(around.world(handle.at));
  if (!at) return;
  if (handle.free)
    for (const [ink, wide] of [
      [token("well"), 6],
      [token("select"), handle.held === FREE ? 4 : 2.5],
    ] as const) {
      pen.strokeStyle = ink;
      pen.lineWidth = wide;
      pen.beginPath();
      pen.arc(at.x, at.y, RING, 0, Math.PI * 2);
      pen.stroke();
    }
  pen.lineWidth = 4;
  pen.strokeStyle = token("well");
  pen.strokeText(handle.words, at.x + 16, at.y + 20);
  pen.fillStyle = token("select");
  pen.fillText(handle.words, at.x + 16, at.y + 20);
}

/** The arrow under a place on the screen; of several the one whose end is nearest. */
export function arrowAt(handle: Handle, around: Surroundings, x: number, y: number): string | null {
  const at = handle.free ? around.screen(around.world(handle.at)) : null;
  if (at && Math.hypot(at.x - x, at.y - y) <= RING + 2) return FREE;
  const near = linesOf(handle, around).flatMap(({ arrow, from, to }) => {
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const along = Math.max(0.25, Math.min(1, ((x - from.x) * dx + (y - from.y) * dy) / (dx * dx + dy * dy || 1)));
    const away = Math.hypot(from.x + dx * along - x, from.y + dy * along - y);
    return away < NEAR ? [{ name: arrow.name, end: Math.hypot(to.x - x, to.y - y) }] : [];
  });
  return near.sort((a, b) => a.end - b.end)[0]?.name ?? null;
}

/** How far the pointer pulls from the handle, in the actor's unit and axes: along an arrow's line, where the ray through
 * it comes nearest, or across the picture. */
export function pullOf(
  handle: Handle,
  around: Surroundings,
  name: string,
  x: number,
  y: number,
  width: number,
  height: number,
): Vector {
  const { camera } = around;
  const start = around.world(handle.at);
  const ray = new THREE.Vector3((x / width) * 2 - 1, 1 - (y / height) * 2, 0.5)
    .unproject(camera)
    .sub(camera.position)
    .normalize();
  const between = start.clone().sub(camera.position);
  if (name === FREE) {
    const ahead = camera.getWorldDirection(new THREE.Vector3());
    const by = ray.multiplyScalar(ahead.dot(between) / ahead.dot(ray)).sub(between);
    const way = by.divideScalar(around.metres);
    return around.zUp ? [way.x, -way.z, way.y] : [way.x, way.y, way.z];
  }
  const arrow = handle.arrows.find((one) => one.name === name);
  if (!arrow) return [0, 0, 0];
  const along = (by: number): Vector => [by * arrow.direction[0], by * arrow.direction[1], by * arrow.direction[2]];
  const end = handle.at.map((one, axis) => one + numberAt(arrow.direction, axis)) as Vector;
  const line = around.world(end).sub(start).normalize();
  const across = line.dot(ray);
  // A line that points at the eye cannot be pulled along.
  if (1 - across * across < 0.01) return [0, 0, 0];
  return along((across * ray.dot(between) - line.dot(between)) / (1 - across * across) / around.metres);
}
