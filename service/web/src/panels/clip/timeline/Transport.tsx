/** Play, step, speed, and the time in words. The time writes its own text nodes: no component renders per frame. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { clock } from "../../../motion/timeline/clock";
import type { Clip } from "../../../state/clip/clip";
import { timeAs } from "../../../state/session/settings";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { number, w } from "../../../words";
import { FramesMenu } from "./FramesMenu";
import { Suggestions } from "./Suggestions";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export function Transport({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { player } = clip;
  const field = useRef<HTMLInputElement>(null);
  const time = useRef<HTMLSpanElement>(null);
  useEffect(
    () =>
      effect(() => {
        const frame = player.frame.value;
        if (field.current && document.activeElement !== field.current) field.current.value = String(frame + 1);
        if (time.current) time.current.textContent = clock(frame, player.perSecond, timeAs.value === "timecode");
      }),
    [clip],
  );
  const loop = player.loop.value;
  const button = (
    icon: "first" | "back" | "next" | "last",
    word: "firstFrame" | "backFrame" | "nextFrame" | "lastFrame",
    run: () => void,
  ) => (
    <button
      type="button"
      class="button quiet icon dense"
      aria-label={w(`label.${word}`)}
      title={w(`label.${word}`)}
      onClick={run}
    >
      <Icon name={icon} />
    </button>
  );
  return (
    <div class="transport row" role="toolbar" aria-label={w("button.play")}>
      {button("first", "firstFrame", () => player.seek(player.range[0]))}
      {button("back", "backFrame", () => player.step(-1))}
      <button
        type="button"
        class="button quiet icon play"
        aria-label={w(player.playing.value ? "button.pause" : "button.play")}
        title={`${w(player.playing.value ? "button.pause" : "button.play")} (Space)`}
        onClick={() => player.toggle()}
      >
        <Icon name={player.playing.value ? "pause" : "play"} />
      </button>
      {button("next", "nextFrame", () => player.step(1))}
      {button("last", "lastFrame", () => player.seek(player.range[1]))}
      <input
        ref={field}
        class="field frame-field"
        aria-label={w("label.frame")}
        inputMode="numeric"
        onChange={(event) => {
          player.pause();
          player.seek(Number(event.currentTarget.value) - 1);
          event.currentTarget.blur();
        }}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
        }}
      />
      <span class="dim nowrap">{w("label.ofFrames", { n: clip.frames })}</span>
      <button
        type="button"
        class="button quiet dense time"
        title={w("label.timeAs")}
        onClick={() => (timeAs.value = timeAs.value === "timecode" ? "seconds" : "timecode")}
      >
        <span ref={time} />
      </button>
      <Menu
        label={w("label.speed")}
        className="button quiet dense"
        items={SPEEDS.map((one) => ({
          text: `${number(one)}×`,
          checked: player.speed.value === one,
          run: () => (player.speed.value = one),
        }))}
      >
        {number(player.speed.value)}×<Icon name="down" />
      </Menu>
      <span class="grow" />
      <Suggestions clip={clip} />
      <FramesMenu clip={clip} range={loop && [loop[0] + 1, loop[1] + 1]} reload={reload} />
      {loop ? (
        <button
          type="button"
          class="button quiet dense"
          title={w("button.clearLoop")}
          onClick={() => (player.loop.value = null)}
        >
          {w("label.loop", { first: loop[0] + 1, last: loop[1] + 1, n: loop[1] - loop[0] + 1 })}
          <Icon name="close" />
        </button>
      ) : (
        <span class="dim nowrap loop-words">{w("label.noLoop")}</span>
      )}
    </div>
  );
}
