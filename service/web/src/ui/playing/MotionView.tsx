/** Bodies that move, for pages besides the clip's own: runs of a query, pieces of a composition, two bodies side by side. */
import { numberAt } from "../../lists";
import { effect, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Skeleton } from "../../motion/body/skeleton";
import { fartherOff } from "../../scene/framing";
import { Stage } from "../../scene/stage";
import { colour, look } from "../../state/session/settings";
import { w } from "../../words";

export interface Actor {
  skeleton: Skeleton;
  /** Positions at the time that is shown; signals that it reads draw it again. */
  positions: () => Float32Array | null;
  shift?: number;
  dim?: boolean;
  /** Stay on the spot: what two bodies do is compared, not where they go. */
  inPlace?: boolean;
  /** Told the place, in its own unit, that is drawn at the origin, of an actor that stays on the spot. */
  onBase?: (base: readonly number[]) => void;
}

/** Takes hold of arrows on the stage, at places of its canvas. */
export interface Puller {
  /** false: there is no arrow. */ grab: (x: number, y: number) => boolean;
  pull: (x: number, y: number) => void;
  drop: () => void;
}

export function MotionView({
  actors,
  selected,
  onPick,
  onStage,
  puller,
  label,
  names = false,
  away = 1,
}: {
  actors: Actor[];
  /** Points of the first actor that are marked. */
  selected?: Signal<number[]>;
  onPick?: (actor: number, point: number) => void;
  /** The stage, whenever it is made: for pictures of it. */
  onStage?: (stage: Stage) => void;
  puller?: Puller;
  label: string;
  names?: boolean;
  /** Times the usual distance of the camera, such as for bodies that travel. */
  away?: number;
}) {
  const pulling = useRef(false);
  const place = (event: PointerEvent): [number, number] => {
    const box = host.current!.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const host = useRef<HTMLDivElement>(null);
  const stage = useRef<Stage | null>(null);
  useEffect(() => {
    if (!actors.length) return;
    let made: Stage;
    try {
      made = new Stage(host.current!, colour);
    } catch {
      return; // Without WebGL the lists say the same.
    }
    stage.current = made;
    onStage?.(made);
    made.shown = { follow: true, ghosts: false, trails: false, names, axes: false, body: false };
    let framed = false;
    const floors: number[] = [];
    const numbers = actors.map((one) => made.add(one.skeleton, { shift: one.shift, dim: one.dim }));
    const stops = [
      effect(() => {
        look.value;
        made.recolour();
      }),
      effect(() => {
        let there = true;
        actors.forEach((one, index) => {
          const positions = one.inPlace ? standing(one, one.positions(), floors, index) : one.positions();
          there &&= positions !== null;
          made.pose(numberAt(numbers, index), { positions, before: [], trail: [] });
        });
        made.selected = new Set(selected?.value ?? []);
        if (there && !framed) {
          made.setFloor(actors.some((one) => one.inPlace) ? 0 : lowest(actors), 0.5);
          framed = made.frame("persp");
          if (framed && away !== 1) made.cameraText = fartherOff(made.cameraText, away);
        }
      }),
    ];
    return () => {
      for (const stop of stops) stop();
      made.close();
      stage.current = null;
    };
  }, [actors]);
  return (
    <div
      class="stage motion-view"
      ref={host}
      role="img"
      aria-label={label}
      onPointerDownCapture={(event) => {
        pulling.current = !event.button && Boolean(puller?.grab(...place(event)));
        if (pulling.current) event.currentTarget.setPointerCapture(event.pointerId);
      }}
      onPointerMove={(event) => {
        if (pulling.current) puller?.pull(...place(event));
      }}
      onPointerCancel={() => {
        if (pulling.current) puller?.drop();
        pulling.current = false;
      }}
      onPointerUp={(event) => {
        if (pulling.current) {
          pulling.current = false;
          puller?.drop();
          return;
        }
        const found = stage.current?.pick(...place(event));
        if (found) onPick?.(found.actor, found.point);
      }}
    >
      {!actors.length && <div class="empty dim">{w("help.nothingFound")}</div>}
    </div>
  );
}

/** The first joint that branches: some files have a root that stays on the ground. */
function pelvisOf({ parents, points }: Skeleton): number {
  const children = new Int32Array(points);
  for (const parent of parents) if (parent >= 0) children[parent] = numberAt(children, parent) + 1;
  return Math.max(
    0,
    children.findIndex((count) => count > 1),
  );
}

/** The pose over the origin, its feet on the ground as they stood when it was seen first. */
function standing(
  { skeleton, onBase }: Actor,
  positions: Float32Array | null,
  floors: number[],
  index: number,
): Float32Array | null {
  if (!positions) return null;
  const up = skeleton.zUp ? 2 : 1;
  if (floors[index] === undefined) {
    let least = Infinity;
    for (let at = up; at < positions.length; at += 3) least = Math.min(least, numberAt(positions, at));
    floors[index] = Number.isFinite(least) ? least : 0;
  }
  const pelvis = pelvisOf(skeleton) * 3;
  const base = Array.from(positions.subarray(pelvis, pelvis + 3));
  base[up] = numberAt(floors, index);
  onBase?.(base);
  return positions.map((value, at) => value - numberAt(base, at % 3));
}

function lowest(actors: Actor[]): number {
  let least = Infinity;
  for (const { skeleton, positions } of actors) {
    const values = positions();
    for (let at = skeleton.zUp ? 2 : 1; values && at < values.length; at += 3)
      if (numberAt(values, at) * skeleton.metres < least) least = numberAt(values, at) * skeleton.metres;
  }
  return Number.isFinite(least) ? least : 0;
}
