/** Draws a clip's row: speed, pins, crosses, bars, playhead. */
import { colour } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import type { ClipRow } from "./rows";

/** Pixels within which a pointer means a beat. */
export const NEAR = 7;
const BARS = 15; // px at the foot
const HEAD = 15; // px for pins
const SAME = 0.02; // seconds

export interface Dragged {
  index: number;
  at: number;
}
interface How {
  ink: string;
  stale: boolean;
  at: number | null;
  beat: number;
  drag: Dragged | null;
}

export function drawLane(canvas: HTMLCanvasElement, row: ClipRow, how: How): void {
  const { pen, width, height } = penOf(canvas);
  if (!width) return;
  const x = (seconds: number) => (seconds / (row.seconds || 1)) * width;
  const foot = height - BARS;
  bars(pen, row, how, x, foot, height);
  speed(pen, row, width, foot);
  crosses(pen, row, x);
  pins(pen, row, how, x, foot);
  if (how.at !== null) {
    pen.fillStyle = colour("accent");
    pen.fillRect(x(how.at) - 0.75, 0, 1.5, height);
  }
}

function bars(
  pen: CanvasRenderingContext2D,
  row: ClipRow,
  how: How,
  x: (seconds: number) => number,
  foot: number,
  height: number,
): void {
  pen.font = `600 11px ${getComputedStyle(pen.canvas).fontFamily}`;
  pen.textBaseline = "middle";
  for (const bar of row.bars) {
    const [from, to] = [x(bar.from), x(bar.to)];
    pen.globalAlpha = how.stale ? 0.08 : bar.number % 2 ? 0.3 : 0.2;
    pen.fillStyle = how.ink;
    pen.fillRect(from, foot, to - from, BARS);
    pen.globalAlpha = how.stale ? 0.35 : 1;
    pen.fillRect(from, height - 2, to - from - 1, 2);
    pen.fillStyle = colour("text2");
    if (to - from > 14) pen.fillText(String(bar.number), from + 4, foot + BARS / 2 - 0.5);
    pen.globalAlpha = 1;
  }
}

function speed(pen: CanvasRenderingContext2D, row: ClipRow, width: number, foot: number): void {
  const top = HEAD + 2;
  // Up to three mean speeds: a leap out of a first pose does not flatten what is danced.
  const most =
    Math.min(
      row.speed.reduce((a, b) => Math.max(a, b), 0),
      row.mean * 3.2,
    ) || 1;
  pen.strokeStyle = colour("centre");
  pen.globalAlpha = 0.8;
  pen.lineWidth = 1.2;
  pen.beginPath();
  row.speed.forEach((value, at) => {
    const place = ((at * row.step) / Math.max(1, row.frames - 1)) * width;
    pen.lineTo(place, foot - 1 - Math.min(1, value / most) * (foot - 1 - top));
  });
  pen.stroke();
  pen.globalAlpha = 1;
}

function crosses(pen: CanvasRenderingContext2D, row: ClipRow, x: (seconds: number) => number): void {
  pen.strokeStyle = colour("text3");
  pen.lineWidth = 1.2;
  pen.beginPath();
  for (const one of row.candidates) {
    if (one.verdict === "beat" || row.beats.some((beat) => Math.abs(beat.at - one.at) < SAME)) continue;
    const here = x(one.at);
    pen.moveTo(here - 3, HEAD / 2 - 2);
    pen.lineTo(here + 3, HEAD / 2 + 4);
    pen.moveTo(here + 3, HEAD / 2 - 2);
    pen.lineTo(here - 3, HEAD / 2 + 4);
  }
  pen.stroke();
}

function pins(
  pen: CanvasRenderingContext2D,
  row: ClipRow,
  how: How,
  x: (seconds: number) => number,
  foot: number,
): void {
  const [accent, selected] = [colour("accent"), colour("select")];
  row.beats.forEach((one, index) => {
    const here = x(how.drag?.index === index ? how.drag.at : one.at);
    pen.strokeStyle = pen.fillStyle = index === how.beat ? selected : accent;
    pen.lineWidth = 1;
    pen.globalAlpha = index === how.beat ? 0.9 : 0.35;
    pen.beginPath();
    pen.moveTo(here, HEAD);
    pen.lineTo(here, foot);
    pen.stroke();
    pen.globalAlpha = 1;
    pen.lineWidth = 1.8;
    pen.beginPath();
    if (one.kind === "hand") pen.rect(here - 4, 5, 8, 8);
    else pen.arc(here, 9, 4, 0, 7);
    if (one.kind === "tracked") pen.stroke();
    else pen.fill();
    if (index !== how.beat) return;
    pen.beginPath();
    pen.arc(here, 9, 7.5, 0, 7);
    pen.stroke();
  });
}
