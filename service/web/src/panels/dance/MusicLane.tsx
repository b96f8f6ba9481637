/** The outline of the music with its beats; dragged, it says where in it the dance begins. */
import { numberAt } from "../../lists";
import { useEffect, useRef } from "preact/hooks";
import { colour, look } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import { number } from "../../words";
import { offsetNow, setOffset } from "./keys";
import type { Music } from "./music";
import { d } from "./words";

const STEP = 0.01;

export function MusicLane({ music }: { music: Music }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const drag = useRef<{ x: number; offset: number } | null>(null);
  const offset = offsetNow();
  const skin = look.value;
  const first = music.beats[music.downbeat - 1];
  useEffect(() => {
    const element = canvas.current!;
    const paint = () => draw(element, music, offset);
    const observer = new ResizeObserver(paint);
    observer.observe(element);
    paint();
    return () => observer.disconnect();
  }, [music, offset, skin]);
  const move = (event: PointerEvent) => {
    if (!drag.current) return;
    setOffset(drag.current.offset - ((event.clientX - drag.current.x) / canvas.current!.clientWidth) * music.seconds);
  };
  return (
    <article class="bench-row" aria-label={d("label.music")}>
      <header>
        <strong class="cut">{music.file.name}</strong>
        <span class="dim">{music.even ? d("label.ofMusic", { bpm: number(music.bpm, 1) }) : d("label.uneven")}</span>
        <span class="dim cut" title={d("help.offsetHelp")}>
          {music.address ? d("help.longMusic") : music.buffer ? d("help.offsetHelp") : d("error.notSound")}
        </span>
      </header>
      <div
        class="lane music"
        role="slider"
        tabIndex={0}
        aria-label={d("label.offset")}
        aria-valuenow={offset}
        aria-valuemin={-music.seconds}
        aria-valuemax={music.seconds}
        aria-valuetext={`${number(offset, 3)} s`}
        onKeyDown={(event) => {
          const by = { ArrowLeft: -STEP, ArrowRight: STEP, PageDown: -0.1, PageUp: 0.1 }[event.key];
          if (!by) return;
          setOffset(offsetNow() + by);
          event.preventDefault();
        }}
      >
        <canvas
          ref={canvas}
          aria-hidden="true"
          onPointerDown={(event) => {
            drag.current = { x: event.clientX, offset: offsetNow() };
            event.currentTarget.setPointerCapture(event.pointerId);
          }}
          onPointerMove={move}
          onPointerUp={() => {
            drag.current = null;
          }}
        />
        <span class="unseen">
          {d("label.downbeat")} {music.downbeat}: {number(first ?? 0, 2)} s
        </span>
      </div>
    </article>
  );
}

/** The dance's time runs from left to right: the sound is shifted by the offset. */
function draw(canvas: HTMLCanvasElement, music: Music, offset: number): void {
  const { pen, width, height } = penOf(canvas);
  const x = (seconds: number) => ((seconds - offset) / music.seconds) * width;
  const middle = height / 2;
  if (music.peaks) {
    pen.fillStyle = colour("text3");
    const count = music.peaks.length / 2;
    for (let at = 0; at < count; at++) {
      const top = numberAt(music.peaks, at * 2 + 1) * (middle - 4);
      const low = numberAt(music.peaks, at * 2) * (middle - 4);
      pen.fillRect(x((at / count) * music.seconds), middle - top, Math.max(0.6, width / count), Math.max(1, top - low));
    }
  }
  music.beats.forEach((at, index) => {
    const bar = (index - music.downbeat + 1) % 4 === 0 && index >= music.downbeat - 1;
    pen.fillStyle = colour(bar ? "select" : "accent");
    pen.globalAlpha = bar ? 1 : 0.6;
    pen.fillRect(x(at) - 0.5, bar ? 0 : height - 10, bar ? 1.5 : 1, bar ? height : 10);
  });
  pen.globalAlpha = 1;
}
