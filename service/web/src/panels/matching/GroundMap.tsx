/** The ground from above: where the body went, the path that it follows, and a hand that draws another. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { TargetedPointerEvent } from "preact";
import { effect } from "@preact/signals";
import { Path } from "../../motion/matching/goals";
import type { Point } from "../../motion/matching/library";
import { colour, look } from "../../state/session/settings";
import { penOf } from "../../ui/canvas";
import type { Session } from "./session";
import { m } from "./words";

const SCALE = 22; // px a metre
const APART = 0.15; // metres between the places of a drawn path
const SHORTEST = 0.5; // metres: a press is no path

export function GroundMap({ session, onPath }: { session: Session; onPath: (path: Path) => void }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [drawing, setDrawing] = useState<Point[] | null>(null);
  const { zUp } = session.loaded.skeleton;
  useEffect(
    () =>
      effect(() => {
        session.drawn.value;
        look.value;
        if (canvas.current) paint(canvas.current, session, drawing ?? session.path.value?.places ?? [], zUp);
      }),
    [session, drawing, zUp],
  );
  const at = (event: TargetedPointerEvent<HTMLCanvasElement>): Point => {
    const box = event.currentTarget.getBoundingClientRect();
    const x = (event.clientX - box.left - box.width / 2) / SCALE;
    const y = (event.clientY - box.top - box.height / 2) / SCALE;
    const [middleX, middleY] = toMap(session.walker.place, zUp);
    return fromMap([x + middleX, y + middleY], zUp);
  };
  const end = () => {
    if (!drawing) return;
    setDrawing(null);
    if (drawing.length * APART > SHORTEST) onPath(new Path(drawing));
  };
  return (
    <canvas
      ref={canvas}
      class="ground-map"
      role="img"
      aria-label={m("label.map")}
      title={m("label.map")}
      onPointerDown={(event) => {
        session.pause();
        event.currentTarget.setPointerCapture(event.pointerId);
        setDrawing([at(event)]);
      }}
      onPointerMove={(event) => {
        const last = drawing?.at(-1);
        if (!last) return;
        const next = at(event);
        if (Math.hypot(next[0] - last[0], next[1] - last[1]) > APART) setDrawing((points) => [...(points ?? []), next]);
      }}
      onPointerUp={end}
      onPointerCancel={() => setDrawing(null)}
    />
  );
}

/** A place on the ground as it lies on the map, metres to the right and down: as the stage shows it from above. */
const toMap = ([first, second]: Point, zUp: boolean): Point => (zUp ? [first, -second] : [second, first]);
const fromMap = ([x, y]: Point, zUp: boolean): Point => (zUp ? [x, -y] : [y, x]);

function paint(canvas: HTMLCanvasElement, session: Session, path: readonly Point[], zUp: boolean): void {
  const { pen, width, height } = penOf(canvas);
  const [middleX, middleY] = toMap(session.walker.place, zUp);
  const place = (point: Point): Point => {
    const [x, y] = toMap(point, zUp);
    return [(x - middleX) * SCALE + width / 2, (y - middleY) * SCALE + height / 2];
  };
  pen.lineWidth = 1;
  pen.strokeStyle = colour("line");
  pen.beginPath();
  const [left, top] = [
    ((width / 2 - middleX * SCALE) % SCALE) - SCALE,
    ((height / 2 - middleY * SCALE) % SCALE) - SCALE,
  ];
  for (let x = left; x < width + SCALE; x += SCALE) pen.rect(Math.round(x) + 0.5, -1, 0, height + 2);
  for (let y = top; y < height + SCALE; y += SCALE) pen.rect(-1, Math.round(y) + 0.5, width + 2, 0);
  pen.stroke();
  const line = (points: readonly Point[], ink: string, thick: number) => {
    pen.strokeStyle = colour(ink);
    pen.lineWidth = thick;
    pen.beginPath();
    points.forEach((point, index) => pen[index ? "lineTo" : "moveTo"](...place(point)));
    pen.stroke();
  };
  line(path, "select", 2);
  line(session.trail, "accent", 2);
  const { facing } = session.walker;
  const [x, y] = place(session.walker.place);
  const ahead: Point = [
    session.walker.place[0] + 0.5 * Math.cos(facing),
    session.walker.place[1] + 0.5 * Math.sin(facing),
  ];
  line([session.walker.place, ahead], "text", 3);
  pen.fillStyle = colour("text");
  pen.beginPath();
  pen.arc(x, y, 5, 0, 2 * Math.PI);
  pen.fill();
}
