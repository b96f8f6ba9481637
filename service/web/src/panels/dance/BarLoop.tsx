/** A bar that moves in a small picture: the frames of its clip, seen from the front and a little from the side. */
import { itemAt, numberAt } from "../../lists";
import { useEffect, useRef } from "preact/hooks";
import { motionOf, type Motion } from "../../motion/loading/source";
import { reducedMotion } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import { inksNow } from "../../ui/clips/ThumbnailView";
import type { Place } from "./bench";

const [ACROSS, DEPTH] = [0.87, 0.5];

export function BarLoop({ place }: { place: Place }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    let timer = 0;
    let closed = false;
    void motionOf(place.document).then(
      (motion) => {
        const began = performance.now();
        const length = place.last - place.first + 1;
        const seen = { tall: 0 };
        const draw = (now: number) => {
          if (closed || !canvas.current) return;
          const by = reducedMotion.matches ? 0 : Math.floor(((now - began) / 1000) * motion.perSecond) % length;
          const frame = Math.min(motion.frames - 1, place.first - 1 + by);
          motion.blocks.want(frame);
          const positions = motion.blocks.frame(frame);
          if (positions) sketch(canvas.current, motion, positions, seen);
          if (!reducedMotion.matches || !positions) timer = requestAnimationFrame(draw);
        };
        draw(began);
      },
      () => undefined,
    );
    return () => {
      closed = true;
      cancelAnimationFrame(timer);
    };
  }, [place.document, place.first, place.last]);
  return <canvas ref={canvas} class="bar-canvas" aria-hidden="true" />;
}

/** The body on its spot. seen: how tall it was so far, in its own unit. */
function sketch(
  canvas: HTMLCanvasElement,
  { skeleton }: Motion,
  positions: Float32Array,
  seen: { tall: number },
): void {
  const { pen, width, height } = penOf(canvas);
  const up = skeleton.zUp ? 2 : 1;
  const side = skeleton.zUp ? 1 : 2;
  let [least, most] = [Infinity, -Infinity];
  let [midX, midSide, count] = [0, 0, 0];
  for (let at = 0; at < positions.length; at += 3) {
    if (positions[at] !== positions[at]) continue;
    least = Math.min(least, numberAt(positions, at + up));
    most = Math.max(most, numberAt(positions, at + up));
    midX += numberAt(positions, at);
    midSide += numberAt(positions, at + side);
    count++;
  }
  seen.tall = Math.max(seen.tall, most - least);
  const scale = (height - 16) / (seen.tall * 1.05 || 1);
  const x = (point: number) =>
    width / 2 +
    ((numberAt(positions, point * 3) - midX / count) * ACROSS +
      (numberAt(positions, point * 3 + side) - midSide / count) * DEPTH * (skeleton.zUp ? -1 : 1)) *
      scale;
  const y = (point: number) => height - 8 - (numberAt(positions, point * 3 + up) - least) * scale;
  const { sides } = inksNow();
  pen.lineWidth = 2;
  pen.lineCap = "round";
  for (let at = 0; at < skeleton.edges.length; at += 2) {
    const [one, other] = [numberAt(skeleton.edges, at), numberAt(skeleton.edges, at + 1)];
    pen.strokeStyle = itemAt(sides, numberAt(skeleton.sides, other));
    pen.beginPath();
    pen.moveTo(x(one), y(one));
    pen.lineTo(x(other), y(other));
    pen.stroke();
  }
}
