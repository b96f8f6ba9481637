/** A card's moving skeleton. One clock for all: only those that run ask for it. */
import { useEffect, useRef } from "preact/hooks";
import { drawThumbnail, type Inks, type Thumbnail } from "../../motion/loading/thumbnail";
import { colour, look, reducedMotion } from "../../state/session/settings";

const running = new Set<(seconds: number) => void>();
let clock = 0;

function tick(now: number): void {
  clock = 0;
  for (const draw of running) draw(now / 1000);
  if (running.size && !document.hidden) clock = requestAnimationFrame(tick);
}

function start(draw: (seconds: number) => void): () => void {
  running.add(draw);
  if (!clock) clock = requestAnimationFrame(tick);
  return () => running.delete(draw);
}
document.addEventListener("visibilitychange", () => {
  if (!document.hidden && running.size && !clock) clock = requestAnimationFrame(tick);
});

export function inksNow(): Inks {
  return { sides: [colour("centre"), colour("left"), colour("right")], line: colour("line") };
}

export function ThumbnailView({
  thumbnail,
  runs,
  scrub = null,
  label,
}: {
  thumbnail: Thumbnail | null;
  runs: boolean;
  /** 0 to 1 of the whole clip, where the pointer is; null: the loop, or its poster. */
  scrub?: number | null;
  /** What it shows, where no words beside it say so; else "". */
  label: string;
}) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const skin = look.value;
  useEffect(() => {
    const element = canvas.current;
    if (!element || !thumbnail) return;
    const inks = inksNow();
    const pen = element.getContext("2d")!;
    const fit = (): [number, number] => {
      const ratio = Math.min(devicePixelRatio, 2);
      const [width, height] = [element.clientWidth, element.clientHeight];
      if (element.width !== Math.round(width * ratio) || element.height !== Math.round(height * ratio)) {
        element.width = Math.round(width * ratio);
        element.height = Math.round(height * ratio);
      }
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      return [width, height];
    };
    const draw = (phase: number | null, whole = false) => drawThumbnail(pen, thumbnail, ...fit(), phase, inks, whole);
    if (scrub !== null) return void draw(scrub, true);
    if (!runs || reducedMotion.matches) return void draw(null);
    const length = Math.max(0.4, thumbnail.seconds) + 0.35; // a breath before it begins again
    const began = performance.now() / 1000;
    return start((now) => draw(Math.min(1, ((now - began) % length) / Math.max(0.4, thumbnail.seconds))));
  }, [thumbnail, runs, scrub, skin]);
  return (
    <canvas
      ref={canvas}
      class="thumbnail"
      role={label ? "img" : undefined}
      aria-label={label || undefined}
      aria-hidden={label ? undefined : true}
    />
  );
}
