/** A face as dots, small: for candidates and keys of a path. */
import { numberAt } from "../../lists";
import { useEffect, useRef } from "preact/hooks";
import { seenFrom } from "../../motion/faces/faces";
import { colour, look } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import type { Space } from "./space";

export function FaceThumb({ space, frame }: { space: Space; frame: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const face = space.face(frame);
  const skin = look.value;
  useEffect(() => {
    const element = canvas.current!;
    const { pen, width, height } = penOf(element);
    if (!face) return;
    const frameOf = seenFrom(space.facing, space.neutral);
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let at = 0; at < frameOf.length; at += 2) {
      if (frameOf[at] !== frameOf[at]) continue;
      left = Math.min(left, numberAt(frameOf, at));
      right = Math.max(right, numberAt(frameOf, at));
      low = Math.min(low, numberAt(frameOf, at + 1));
      high = Math.max(high, numberAt(frameOf, at + 1));
    }
    const scale = Math.min((width - 8) / (right - left || 1), (height - 8) / (high - low || 1));
    const places = seenFrom(space.facing, face);
    pen.fillStyle = colour("accent");
    const size = places.length > 240 ? 1.2 : 1.7;
    for (let at = 0; at < places.length; at += 2) {
      if (places[at] !== places[at]) continue;
      pen.beginPath();
      pen.arc(
        width / 2 + (numberAt(places, at) - (left + right) / 2) * scale,
        height / 2 - (numberAt(places, at + 1) - (low + high) / 2) * scale,
        size,
        0,
        Math.PI * 2,
      );
      pen.fill();
    }
  }, [face, skin, space]);
  return <canvas ref={canvas} class="face-thumb" aria-hidden="true" />;
}
