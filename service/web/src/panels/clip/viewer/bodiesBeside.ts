/** Bodies of other clips on the viewer's stage: placed beside the open clip's or over it, in step with it. */
import { itemAt, numberAt } from "../../../lists";
import { effect } from "@preact/signals";
import { anchorOf, frameBeside } from "../../../motion/comparison/sync";
import type { Skeleton } from "../../../motion/body/skeleton";
import { characterOf, wornAt } from "../../../motion/loading/character";
import type { Pose, Stage } from "../../../scene/stage";
import { chosenCharacter } from "../../../state/clip/characters";
import type { Clip } from "../../../state/clip/clip";
import type { Player } from "../../../state/clip/player";
import { BESIDE_COLOURS, beside, besideSync, laidOver, type Beside } from "../../../state/clip/comparison";
import { cameraView, shown } from "../actions";
import { floorOf } from "./ground";

const APART = 0.65; // of the taller body's height

export function bodiesBeside(clip: Clip, stage: Stage, own: number): () => void {
  const actors = new Map<string, number>();
  let framed = "";
  return effect(() => {
    const others = beside.value;
    const sync = besideSync();
    const over = laidOver();
    const { player, skeleton } = clip;
    const frame = player.frame.value;
    stage.paint(own, others.length ? BESIDE_COLOURS[0] : null);
    for (const [id, actor] of actors)
      if (!others.some((one) => one.id === id)) stage.pose(actor, { positions: null, before: [], trail: [] });
    if (!others.length) return void (framed = "");
    clip.blocks.arrived.value;
    const here = { frames: clip.frames, perSecond: player.perSecond, labels: clip.labels.value };
    let there = true;
    others.forEach((one, place) => {
      one.blocks.arrived.value;
      const anchor = anchorOf(here, one, sync, frame);
      const at = frameBeside(here, one, sync, frame, anchor);
      one.blocks.want(at, player.playing.value ? Math.sign(player.speed.value) : 0, one.perSecond);
      if (!actors.has(one.id)) actors.set(one.id, stage.add(one.skeleton));
      const actor = actors.get(one.id)!;
      const clothes = clothesOf(stage, actor, one, at, player);
      stage.paint(actor, itemAt(BESIDE_COLOURS, place + 1));
      const [from, to] = [
        rootAt(skeleton, clip.blocks.frame(anchor.here)),
        rootAt(one.skeleton, one.blocks.frame(anchor.there)),
      ];
      const positions = one.blocks.frame(at);
      const overview = one.blocks.overview();
      there &&= Boolean(from && to && positions && overview);
      if (!from || !to || !positions || !overview) return;
      const apart = over
        ? 0
        : APART * Math.max(skeleton.height, ...others.map((other) => other.skeleton.height)) * (place + 1);
      stage.place(
        actor,
        from[0] - to[0] + apart,
        stage.floorHeight - floorOf(one.skeleton, overview.values),
        from[2] - to[2],
      );
      stage.pose(actor, { positions, ...clothes, before: [], trail: [] });
    });
    // The camera moves when something came or went, not with the motion.
    const now = `${others.map((one) => one.id).join()} ${over}`;
    if (there && framed !== now && stage.frame(cameraView.peek())) framed = now;
  });
}

/** Dress a body where bodies are wanted. Returns what moves it in a frame; nothing: it is drawn as bones. */
function clothesOf(stage: Stage, actor: number, one: Beside, at: number, player: Player): Pick<Pose, "turns" | "worn"> {
  const body = shown.value.body ? characterOf(one, chosenCharacter.value).value : null;
  stage.dress(actor, body?.skin ?? null);
  if (!body?.skin) return {};
  const direction = player.playing.value ? Math.sign(player.speed.value) : 0;
  const blocks = body.frames ? [body.frames.positions, body.frames.rotations] : [one.rotations];
  for (const each of blocks) {
    each.arrived.value;
    each.want(at, direction, one.perSecond);
  }
  if (body.frames) return { worn: wornAt(body, at) };
  return { turns: one.blocks.has(at) && one.rotations.has(at) ? one.rotations.frame(at) : null };
}

/** Where the first joint is, metres in the world's axes. */
function rootAt({ metres, zUp }: Skeleton, positions: Float32Array | null): [number, number, number] | null {
  if (!positions || positions[0] !== positions[0]) return null;
  const [x, y, z] = [numberAt(positions, 0) * metres, numberAt(positions, 1) * metres, numberAt(positions, 2) * metres];
  return zUp ? [x, z, -y] : [x, y, z];
}
