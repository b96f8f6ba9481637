/** The body and the map, what leads it, and saving it. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import { Path } from "../../motion/matching/goals";
import type { Point } from "../../motion/matching/library";
import type { Stage } from "../../scene/stage";
import { note } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { AskName } from "../../ui/forms/AskName";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { number } from "../../words";
import { GroundMap } from "./GroundMap";
import { Leading, onGround } from "./leading";
import { SHAPES } from "./shapes";
import type { Session } from "./session";
import { m } from "./words";

const AWAY = 1.8; // a body that travels needs room

export function Steering({ session, project }: { session: Session; project: string }) {
  const [saving, setSaving] = useState(false);
  const leading = useLeading(session);
  const actors = useMemo<Actor[]>(
    () => [
      {
        skeleton: session.loaded.skeleton,
        positions: () => {
          session.drawn.value;
          return session.positions;
        },
      },
    ],
    [session],
  );
  const state = session.state.value;
  const follow = (path: Path | null) => {
    session.restart(path);
    session.run();
  };
  const save = async (name: string) => {
    const body = { segments: session.segments, style: "inertial", seconds: 0.3, name, project };
    const made = await ask("post", "/compose", { body: body as unknown as Schemas["ComposeRequest"] });
    const open = () => go(`/clips/${made.document}`);
    note(m("label.saved", { name }), { action: { text: m("button.open"), run: open } });
  };
  return (
    <>
      <div class="matching-tools row wrap">
        <button
          type="button"
          class="button primary"
          disabled={state === "arrived" || state === "full"}
          onClick={() => (state === "running" ? session.pause() : session.run())}
        >
          <Icon name={state === "running" ? "pause" : "play"} />
          {m(state === "running" ? "button.stop" : "button.play")}
        </button>
        <button type="button" class="button" onClick={() => session.restart()}>
          {m("button.anew")}
        </button>
        <span class="row" role="group" aria-label={m("label.paths")}>
          <span class="dim">{m("label.paths")}</span>
          {SHAPES.map(({ word, path }) => (
            <button key={word} type="button" class="button dense" onClick={() => follow(path())}>
              {m(word)}
            </button>
          ))}
        </span>
        <label class="row">
          {m("label.speed")}
          <input
            type="range"
            min="0.2"
            max="5"
            step="0.05"
            value={session.speed.value}
            onInput={(event) => (session.speed.value = event.currentTarget.valueAsNumber)}
          />
          <output>{number(session.speed.value, 2)}</output>
        </label>
        <span class="grow" />
        <button
          type="button"
          class="button"
          disabled={state === "running" || session.seconds === 0}
          onClick={() => setSaving(true)}
        >
          {m("button.save")}
        </button>
      </div>
      <p class="matching-state dim" role="status">
        <Told session={session} />
      </p>
      <div class="matching-stage">
        <MotionView actors={actors} label={m("label.stage")} away={AWAY} onStage={(stage) => (leading.stage = stage)} />
        <GroundMap session={session} onPath={follow} />
        <Arrows session={session} leading={leading.keys} />
      </div>
      {saving && (
        <AskName
          title={m("label.newClip")}
          initial={m("label.defaultName")}
          onName={save}
          onClose={() => setSaving(false)}
        />
      )}
    </>
  );
}

/** What is told of the run; drawn often, so apart. */
function Told({ session }: { session: Session }) {
  session.drawn.value;
  const state = session.state.value;
  const distance = session.distance.value;
  const parts = [
    session.seconds ? m("label.state", { seconds: number(session.seconds, 1), n: session.cuts }) : m("help.drive"),
    distance === null ? "" : m("label.distance", { metres: number(distance, 2) }),
    state === "arrived" ? m("label.arrived") : state === "full" ? m("label.full") : "",
  ];
  return <>{parts.filter(Boolean).join(" · ")}</>;
}

const ARROWS = [
  ["label.forward", "ArrowUp", "↑"],
  ["label.left", "ArrowLeft", "←"],
  ["label.back", "ArrowDown", "↓"],
  ["label.right", "ArrowRight", "→"],
] as const;

/** The keys for hands without a keyboard. */
function Arrows({ session, leading }: { session: Session; leading: Leading }) {
  return (
    <div class="matching-arrows" role="group" aria-label={m("label.steeringKeys")}>
      {ARROWS.map(([word, code, sign]) => (
        <button
          key={code}
          type="button"
          class={`button ${code}`}
          aria-label={m(word)}
          onPointerDown={() => {
            leading.hold(code, true);
            start(session);
          }}
          onPointerUp={() => leading.hold(code, false)}
          onPointerLeave={() => leading.hold(code, false)}
        >
          {sign}
        </button>
      ))}
    </div>
  );
}

/** A hand that leads ends the path, and what it led goes on. */
function start(session: Session): void {
  if (session.path.peek()) session.restart();
  session.run();
}

/** Keys of the window, while nothing is written, and pads. */
function useLeading(session: Session): { keys: Leading; stage: Stage | null } {
  const held = useRef<{ keys: Leading; stage: Stage | null }>({ keys: new Leading(), stage: null });
  useEffect(() => {
    const { keys } = held.current;
    session.lead = (): Point => {
      const { stage } = held.current;
      const camera = stage ? stage.cameraText.split(",").map(Number) : [0, 0, 0, 0, 0, 1];
      return onGround(keys.now, camera, session.loaded.skeleton.zUp);
    };
    const press = (event: KeyboardEvent) => {
      const writes = (event.target as HTMLElement).closest("input, select, textarea, dialog");
      if (writes || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
      if (!keys.hold(event.code, true)) return;
      event.preventDefault();
      event.stopPropagation();
      start(session);
    };
    const release = (event: KeyboardEvent) => void keys.hold(event.code, false);
    const forget = () => keys.release();
    addEventListener("keydown", press, { capture: true });
    addEventListener("keyup", release);
    addEventListener("blur", forget);
    return () => {
      removeEventListener("keydown", press, { capture: true });
      removeEventListener("keyup", release);
      removeEventListener("blur", forget);
    };
  }, [session]);
  return held.current;
}
