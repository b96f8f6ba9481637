/** How far each joint is from where another revision had it, over the frames: a strip for each joint that moved. */
import { itemAt, numberAt } from "../../../lists";
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { LEAST, apart, type Apart } from "../../../motion/comparison/difference";
import type { Clip } from "../../../state/clip/clip";
import type { Compared } from "../../../state/clip/compared";
import { colour, look } from "../../../state/session/settings";
import { number, w } from "../../../words";

const ROW = 14;
const MOST = 24;
const TOLD = 3; // joints that are told in words
const NAME = 110;

export function DifferenceStrip({ clip }: { clip: Clip }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [found, setFound] = useState<{ joints: Apart[]; step: number } | null>(null);
  const [under, setUnder] = useState("");
  const other = clip.compared.value;
  useEffect(
    () =>
      effect(() => {
        const compared = clip.compared.value;
        const newer = compared?.against?.blocks ?? clip.blocks;
        look.value;
        newer.arrived.value;
        const now = newer.overview();
        const element = canvas.current;
        if (!element || !now || !compared) return;
        const { skeleton } = clip;
        const joints = apart(
          now.values,
          compared.rows,
          skeleton.points,
          skeleton.view.bones.length,
          skeleton.metres,
        ).slice(0, MOST);
        draw(element, clip, joints);
        setFound({ joints, step: now.step });
      }),
    [clip],
  );
  const told = (one: Apart, row: number) =>
    w("label.apartAt", {
      name: itemAt(clip.skeleton.view.bones, one.joint).name,
      size: `${number(numberAt(one.away, row) * 100, 1)} cm`,
      n: row * (found?.step ?? 1) + 1,
    });
  const at = (event: PointerEvent): [Apart, number] | null => {
    const one = found?.joints[Math.floor(event.offsetY / ROW)];
    const row = one
      ? Math.floor(((event.offsetX - NAME) / (canvas.current!.clientWidth - NAME)) * one.away.length)
      : -1;
    return one && row >= 0 && row < one.away.length ? [one, row] : null;
  };
  const seek = (row: number) => {
    const frame = other?.seekAt(row * (found?.step ?? 1)) ?? null;
    clip.player.pause();
    if (frame !== null) clip.player.seek(frame);
  };
  return (
    <>
      {other && <p class="dim">{toldOf(other.facts)}</p>}
      <canvas
        ref={canvas}
        class="difference"
        role="img"
        aria-label={w("label.difference")}
        onPointerMove={(event) => {
          const here = at(event);
          setUnder(here ? told(...here) : "");
        }}
        onPointerLeave={() => setUnder("")}
        onClick={(event) => {
          const here = at(event as never);
          if (here) {
            seek(here[1]);
            clip.select([itemAt(clip.skeleton.view.bones, here[0].joint).name]);
          }
        }}
      />
      <ul class="apart">
        {under ? (
          <li>{under}</li>
        ) : (
          found?.joints.slice(0, TOLD).map((one) => (
            <li key={one.joint}>
              <button
                type="button"
                class="button quiet dense"
                onClick={() => {
                  seek(one.at);
                  clip.select([itemAt(clip.skeleton.view.bones, one.joint).name]);
                }}
              >
                {told(one, one.at)}
              </button>
            </li>
          ))
        )}
        {found && !found.joints.length && <li class="dim">{w("help.noDifference")}</li>}
      </ul>
    </>
  );
}

function toldOf({ same, removed, added, byPosition }: Compared["facts"]): string {
  if (byPosition) return w("help.framesByPosition");
  if (!same) return w("help.framesNoneKept");
  return removed || added ? w("help.framesKept", { n: same, removed, added }) : "";
}

function draw(element: HTMLCanvasElement, clip: Clip, joints: Apart[]): void {
  const rows = joints[0]?.away.length ?? 1;
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
    pen.fillText(itemAt(clip.skeleton.view.bones, joint.joint).name.slice(0, 20), 0, index * ROW + ROW / 2);
    pen.fillStyle = colour("warn");
    const wide = (width - NAME) / rows;
    for (let row = 0; row < rows; row++) {
      if (numberAt(joint.away, row) <= LEAST) continue;
      pen.globalAlpha = 0.15 + 0.85 * (numberAt(joint.away, row) / most);
      pen.fillRect(NAME + row * wide, index * ROW + 1, Math.max(1, wide), ROW - 2);
    }
  });
  pen.globalAlpha = 1;
  pen.fillStyle = colour("text3");
  pen.fillText(joints.length ? `≤ ${(most * 100).toFixed(1)} cm` : "0", NAME, height - 8);
}
