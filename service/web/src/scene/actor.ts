/** One skeleton on the stage: its body, its ghosts in time, the lines that its points have gone along. */
import { itemAt, numberAt } from "../lists";
import * as THREE from "three";
import { SIDE_TOKENS, type Skeleton } from "../motion/body/skeleton";
import type { Skin, Worn } from "../motion/body/skin";
import { Body, type Tint } from "./body";
import { Figures } from "./figure";
import { Forces } from "./forces";
import { fillTrails } from "./trails";

export interface Actor {
  skeleton: Skeleton;
  group: THREE.Group;
  body: Body;
  ghosts: Body[];
  /** The body with a skin that stands in the place of bones; null: bones. */
  figures: Figures | null;
  trails: THREE.LineSegments;
  forces: Forces | null;
  shift: THREE.Vector3;
  positions: Float32Array | null;
  dim: boolean;
  /** A token that colours all of it; null: its sides'. */
  ink: string | null;
}

export interface Pose {
  positions: Float32Array | null;
  before: (Float32Array | null)[];
  /** Rotations of the joints from rest, (joints, 4), and of those of `before`: bodies with a skin need them. */
  turns?: Float32Array | null;
  turnsBefore?: (Float32Array | null)[];
  /** The joints of a skin that has its own, in this frame and in those of `before`; null where they are not there. */
  worn?: Worn | null;
  wornBefore?: (Worn | null)[];
  trail: Float32Array[];
  /** Arrows as `arrowsOf` makes them; null, or left out: force plates are hidden. */
  forces?: Float32Array | null;
}

type Token = (name: string) => string;

const TRAIL_POINTS = 4096;
const GHOST_OPACITY = 0.16;
const DIM_OPACITY = 0.45;

export function actorOf(
  skeleton: Skeleton,
  token: Token,
  { shift = 0, dim = false, ink = null }: { shift?: number; dim?: boolean; ink?: string | null },
): Actor {
  const group = new THREE.Group();
  if (skeleton.zUp) group.rotation.x = -Math.PI / 2;
  const tint = tintOf(skeleton, token, ink);
  const body = new Body(skeleton, tint, dim ? DIM_OPACITY : 1);
  const ghosts = [0, 1, 2, 3].map(() => new Body(skeleton, tint, GHOST_OPACITY));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute(
    "position",
    new THREE.BufferAttribute(new Float32Array(TRAIL_POINTS * 6), 3).setUsage(THREE.DynamicDrawUsage),
  );
  geometry.setDrawRange(0, 0);
  const trails = new THREE.LineSegments(
    geometry,
    new THREE.LineBasicMaterial({ color: token("accent"), transparent: true, opacity: 0.75 }),
  );
  trails.frustumCulled = false;
  group.add(body.group, trails, ...ghosts.map((ghost) => ghost.group));
  const forces = skeleton.view.plates.length && !dim ? new Forces(skeleton, token) : null;
  if (forces) group.add(forces.group);
  group.position.set(shift, 0, 0);
  return {
    skeleton,
    group,
    body,
    ghosts,
    trails,
    forces,
    figures: null,
    shift: group.position.clone(),
    positions: null,
    dim,
    ink,
  };
}

/** Put a skin on an actor, or take it off. */
export function dress(actor: Actor, skin: Skin | null, token: Token): void {
  if ((actor.figures?.shape.skin ?? null) === skin) return;
  actor.figures?.dispose();
  const { skeleton, ink, dim } = actor;
  const opacities = [dim ? DIM_OPACITY : 1, ...actor.ghosts.map(() => GHOST_OPACITY)];
  actor.figures = skin && new Figures(skin, skeleton, tintOf(skeleton, token, ink), opacities);
  if (actor.figures) actor.group.add(actor.figures.group);
}

export function pose(actor: Actor, given: Pose): void {
  const { positions, before, turns, turnsBefore, trail, forces = null } = given;
  actor.positions = positions;
  const hasOwn = Boolean(actor.figures?.shape.skin.own);
  const now = hasOwn ? given.worn : { positions, turns };
  const dressed = actor.figures?.pose(0, positions && (now?.positions ?? null), now?.turns) ?? false;
  if (positions && !dressed) actor.body.pose(positions);
  else actor.body.hide();
  actor.ghosts.forEach((ghost, place) => {
    const then = before[place] ?? null;
    const clothes = hasOwn ? given.wornBefore?.[place] : { positions: then, turns: turnsBefore?.[place] };
    const clad = actor.figures?.pose(place + 1, then && (clothes?.positions ?? null), clothes?.turns) ?? false;
    if (then && !clad) ghost.pose(then);
    else ghost.hide();
  });
  fillTrails(actor.trails, trail, actor.skeleton.metres);
  actor.forces?.show(forces);
}

export function recolour(actor: Actor, token: Token): void {
  const tint = tintOf(actor.skeleton, token, actor.ink);
  actor.body.tint(tint);
  actor.figures?.shape.tint(tint);
  for (const ghost of actor.ghosts) ghost.tint(tint);
  (actor.trails.material as THREE.LineBasicMaterial).color.set(token("accent"));
  actor.forces?.recolour(token);
}

export function dispose(actor: Actor): void {
  actor.body.dispose();
  actor.figures?.dispose();
  for (const ghost of actor.ghosts) ghost.dispose();
  actor.trails.geometry.dispose();
  (actor.trails.material as THREE.Material).dispose();
  actor.forces?.dispose();
  actor.group.removeFromParent();
}

function tintOf(skeleton: Skeleton, token: Token, ink: string | null): Tint {
  if (ink) {
    const one = new THREE.Color(token(ink));
    return () => one;
  }
  const colours = SIDE_TOKENS.map((name) => new THREE.Color(token(name)));
  return (point) => itemAt(colours, numberAt(skeleton.sides, point));
}
