/** What moves: a clip or a bar of it, a transition, or the dance with its sound. Below it the dance's figures. */
import { effect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import { partOf, rowsOf, type Result } from "../../api/results";
import { wholeOf, numbersOf } from "../../motion/loading/preview";
import type { Skeleton } from "../../motion/body/skeleton";
import { motionOf } from "../../motion/loading/source";
import { Player } from "../../state/clip/player";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { PlayBar } from "../../ui/playing/PlayBar";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import type { Bench, Place, Shown } from "./bench";
import { Figures } from "./Figures";
import { FloorPlan } from "./FloorPlan";
import { offsetNow } from "./keys";
import { Sound } from "./sound";
import { SoundBar } from "./SoundBar";
import { d } from "./words";

const BLEND = 12; // frames of the transition that is tried
const MOST_FRAMES = 4000;

interface Stage {
  of: Shown;
  skeleton: Skeleton;
  frames: number;
  perSecond: number;
  frame: (index: number) => Float32Array | null;
  want: (index: number, ahead: boolean) => void;
  id: string;
}

declare global {
  interface Window {
    /** What is drawn and what is heard, for tests that compare them. */
    mcmlDance?: {
      frame: () => number;
      reading: (now: number) => number | null;
      led: (now: number) => number | null;
      perSecond: number;
    };
  }
}

/** What is to be seen, as numbers. */
async function staged(shown: Shown, signal: AbortSignal): Promise<Stage> {
  if (shown.kind === "step") {
    const composed = await transition(shown.from, shown.to, signal);
    const preview = wholeOf(composed.motion!, numbersOf(composed.motion!));
    return {
      of: shown,
      id: "",
      skeleton: preview.skeleton,
      frames: preview.frames,
      perSecond: preview.perSecond,
      frame: (index) => preview.frame(index),
      want: () => undefined,
    };
  }
  const id = shown.kind === "clip" ? shown.document : partOf(shown.result, "clip").document!;
  const motion = await motionOf(id);
  return {
    of: shown,
    id,
    skeleton: motion.skeleton,
    frames: motion.frames,
    perSecond: motion.perSecond,
    frame: (index) => {
      motion.blocks.arrived.value;
      return motion.blocks.frame(index);
    },
    want: (index, ahead) => motion.blocks.want(index, ahead ? 1 : 0, motion.perSecond),
  };
}

function transition(from: Place, to: Place, signal: AbortSignal): Promise<Schemas["Composed"]> {
  const segments = [from, to].map((one, at) => ({
    document: one.document,
    first: Math.max(1, one.first),
    last: one.last,
    ...(at ? { transition: BLEND } : {}),
  }));
  const body = { segments, preview: true, style: "crossfade" } as unknown as Schemas["ComposeRequest"];
  return ask("post", "/compose", { body, query: { positions: "f4", step: 1 }, signal });
}

export function StagePane({ bench }: { bench: Bench }) {
  const shown = bench.shown.value;
  const stage = useAsync<Stage | null>(async (signal) => (shown ? staged(shown, signal) : null), [shown]);
  const now = stage.value && stage.value.of === shown ? stage.value : null;
  const dance = shown?.kind === "dance" ? shown.result : null;
  const dry = bench.dry.value;
  return (
    <>
      <div class="row bench-tools">
        <strong>{d("label.stage")}</strong>
        <span class="dim cut grow" role="status">
          {titleOf(bench, shown)}
        </span>
      </div>
      <Trouble error={stage.error} retry={stage.again} />
      {shown ? (
        now ? (
          <Moving key={`${now.id} ${now.of.kind}`} bench={bench} stage={now} />
        ) : (
          <div class="stage motion-view">{!stage.error && <div class="busy" />}</div>
        )
      ) : (
        <div class="empty bench-hint">
          <p>{d("help.nothingYet")}</p>
        </div>
      )}
      {dry && <p class="bench-old">{d("help.dryNote")}</p>}
      {dry && <FloorPlan result={dry} player={null} />}
      {(dry ?? dance) && <Figures bench={bench} result={(dry ?? dance)!} dry={dry !== null} />}
    </>
  );
}

function titleOf(bench: Bench, shown: Shown | null): string {
  if (shown?.kind === "step") return d("label.step", { from: shown.from.bar, to: shown.to.bar });
  if (shown?.kind === "dance") return shown.result.name;
  return shown ? (bench.found.value.get(shown.document)?.name ?? "") : "";
}

function gridOf(result: Result): number[] {
  return (result.parts.speed?.data.grid ?? []) as number[];
}

function Moving({ bench, stage }: { bench: Bench; stage: Stage }) {
  const player = useMemo(
    () => new Player(Math.min(stage.frames, stage.of.kind === "step" ? MOST_FRAMES : Infinity), stage.perSecond),
    [stage],
  );
  const dance = stage.of.kind === "dance" ? stage.of.result : null;
  const grid = useMemo(() => (dance ? gridOf(dance) : []), [dance]);
  const music = bench.music.value;
  useEffect(() => {
    bench.player.value = player;
    const stops: (() => void)[] = [
      effect(() => {
        stage.want(player.frame.value, player.playing.value);
      }),
    ];
    if (stage.of.kind === "clip") {
      const { loop, document } = stage.of;
      player.loop.value = loop ?? null;
      player.seek(loop ? loop[0] : bench.at.peek() * stage.perSecond);
      stops.push(
        player.frame.subscribe((frame) => {
          if (bench.clip.peek() === document) bench.at.value = frame / stage.perSecond;
        }),
      );
    }
    // What was pressed moves; a dance has sound and waits for its own press.
    if (stage.of.kind === "step" || (stage.of.kind === "clip" && stage.of.loop)) player.play(1);
    return () => {
      for (const stop of stops) stop();
      player.pause();
      if (bench.player.peek() === player) bench.player.value = null;
    };
  }, [player]);
  useEffect(() => {
    if (!dance) return;
    const sound = new Sound(grid, music, offsetNow);
    const seconds = stage.frames / stage.perSecond;
    let offset = offsetNow();
    player.lead = (now) => {
      const time = sound.time(now);
      if (time === null || player.speed.peek() !== 1) return null;
      if (time < seconds) return time * stage.perSecond;
      sound.play(0); // The dance begins again, and its sound with it.
      return 0;
    };
    const stops = [
      effect(() => {
        const speed = player.speed.value;
        if (player.playing.value && speed === 1) sound.play(player.frame.peek() / stage.perSecond);
        else sound.stop();
      }),
      effect(() => {
        const next = offsetNow();
        if (next !== offset && player.playing.peek()) sound.play(player.frame.peek() / stage.perSecond);
        offset = next;
      }),
    ];
    window.mcmlDance = {
      frame: () => player.frame.peek(),
      reading: (now) => sound.reading(now),
      led: (now) => sound.time(now),
      perSecond: stage.perSecond,
    };
    return () => {
      for (const stop of stops) stop();
      player.lead = null;
      sound.close();
      window.mcmlDance = undefined;
    };
  }, [player, music, grid]);
  const actors = useMemo<Actor[]>(
    () => [{ skeleton: stage.skeleton, positions: () => stage.frame(player.frame.value) }],
    [player],
  );
  const bands = useMemo(() => (dance ? jumpsOf(dance, stage.perSecond) : []), [dance]);
  return (
    <div class="bench-moving">
      <MotionView actors={actors} label={titleOf(bench, stage.of)} />
      <PlayBar player={player} bands={bands}>
        {dance && <SoundBar />}
      </PlayBar>
      {dance && <FloorPlan result={dance} player={player} />}
    </div>
  );
}

/** Transitions by jumps, on the line of time. */
const jumpsOf = (result: Result, perSecond: number) =>
  rowsOf<{ start: number; end: number }>(result.parts.transitions).map((one) => ({
    from: one.start * perSecond,
    to: one.end * perSecond,
    ink: "warn",
    alpha: 0.5,
  }));
