/** A thin line of time: dragged, moved by arrows; bands show what stands where. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Player } from "../../state/clip/player";
import { clock } from "../../motion/timeline/clock";
import { w } from "../../words";

export interface Band {
  from: number;
  to: number;
  ink: string;
  alpha: number;
}

export function Scrubber({ player, bands = [] }: { player: Player; bands?: Band[] }) {
  const box = useRef<HTMLDivElement>(null);
  const knob = useRef<HTMLSpanElement>(null);
  const time = useRef<HTMLSpanElement>(null);
  useEffect(
    () =>
      effect(() => {
        const frame = player.frame.value;
        const share = player.frames > 1 ? frame / (player.frames - 1) : 0;
        if (knob.current) knob.current.style.left = `${share * 100}%`;
        if (time.current) time.current.textContent = clock(frame, player.perSecond);
        box.current?.setAttribute("aria-valuenow", String(frame + 1));
      }),
    [player],
  );
  const go = (event: PointerEvent) => {
    const bounds = box.current!.getBoundingClientRect();
    player.seek(((event.clientX - bounds.left) / bounds.width) * (player.frames - 1));
  };
  return (
    <>
      <div
        ref={box}
        class="scrubber grow"
        role="slider"
        tabIndex={0}
        aria-label={w("label.frame")}
        aria-valuemin={1}
        aria-valuemax={player.frames}
        aria-valuenow={1}
        onPointerDown={(event) => {
          player.pause();
          event.currentTarget.setPointerCapture(event.pointerId);
          go(event);
          event.currentTarget.onpointermove = go;
        }}
        onPointerUp={(event) => {
          event.currentTarget.onpointermove = null;
        }}
        onKeyDown={(event) => {
          const step = {
            ArrowLeft: -1,
            ArrowRight: 1,
            PageUp: -10,
            PageDown: 10,
            Home: -player.frames,
            End: player.frames,
          }[event.key];
          if (step) {
            player.step(step);
            event.preventDefault();
            event.stopPropagation();
          }
        }}
      >
        {bands.map((band, index) => (
          <span
            key={index}
            class="scrubber-band"
            style={{
              left: `${(band.from / player.frames) * 100}%`,
              width: `${((band.to - band.from) / player.frames) * 100}%`,
              background: `var(--${band.ink})`,
              opacity: band.alpha,
            }}
          />
        ))}
        <span ref={knob} class="scrubber-knob" />
      </div>
      <span ref={time} class="time dim" />
    </>
  );
}
