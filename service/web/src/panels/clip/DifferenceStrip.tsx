/** How far each joint is from where another revision had it, over the frames: a strip for each joint that moved. */
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Clip } from "../../state/clip";
import { colour, look } from "../../state/settings";
import { w } from "../../words";

const ROW = 14;
const MOST = 24;
const NAME = 110;
const LEAST = 1e-4; // metres: less is not seen

export function DifferenceStrip({ clip }: { clip: Clip }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => effect(() => {
    const other = clip.compared.value;
    look.value;
    clip.blocks.arrived.value;
    other?.blocks.arrived.value;
    const [now, then] = [clip.blocks.overview(), other?.blocks.overview()];
    const element = canvas.current;
    if (!element || !now || !then || now.values.length !== then.values.length) return;
    draw(element, clip, now.values, then.values);
  }), [clip]);
  return <canvas ref={canvas} class="difference" role="img" aria-label={w("difference")} />;
}

function draw(element: HTMLCanvasElement, clip: Clip, now: Float32Array, then: Float32Array): void {
  const { skeleton } = clip;
  const stride = skeleton.points * 3;
  const rows = now.length / stride;
  const joints = skeleton.view.bones.map((bone, point) => {
    const away = new Float32Array(rows);
    let most = 0;
    for (let row = 0; row < rows; row++) {
      const at = row * stride + point * 3;
      away[row] = Math.hypot(now[at] - then[at], now[at + 1] - then[at + 1], now[at + 2] - then[at + 2]) * skeleton.metres || 0;
      if (away[row] > most) most = away[row];
    }
    return { name: bone.name, away, most };
  }).filter((one) => one.most > LEAST).sort((a, b) => b.most - a.most).slice(0, MOST);
  const [width, height] = [element.clientWidth, Math.max(1, joints.length) * ROW + 18];
  const ratio = Math.min(devicePixelRatio, 2);
  element.style.height = `${height}px`;
  element.width = width * ratio;
  element.height = height * ratio;
  const pen = element.getContext("2d")!;
  pen.scale(ratio, ratio);
  pen.font = `11px ${getComputedStyle(element).fontFamily}`;
  pen.textBaseline = "middle";
  const most = Math.max(...joints.map((one) => one.most), LEAST);
  joints.forEach((joint, index) => {
    pen.fillStyle = colour("text2");
    pen.globalAlpha = 1;
    pen.fillText(joint.name.slice(0, 20), 0, index * ROW + ROW / 2);
    pen.fillStyle = colour("warn");
    const wide = (width - NAME) / rows;
    for (let row = 0; row < rows; row++) {
      if (joint.away[row] <= LEAST) continue;
      pen.globalAlpha = 0.15 + 0.85 * (joint.away[row] / most);
      pen.fillRect(NAME + row * wide, index * ROW + 1, Math.max(1, wide), ROW - 2);
    }
  });
  pen.globalAlpha = 1;
  pen.fillStyle = colour("text3");
  pen.fillText(joints.length ? `≤ ${(most * 100).toFixed(1)} cm` : "0", NAME, height - 8);
}
