/** Drawings over a video: their points are dragged, or moved with the arrow keys. */
import { useRef } from "preact/hooks";
import { number } from "../../../words";
import { v } from "../words";
import { angleOf, movePoint, type Drawing, type Point } from "./drawing";

const STEPS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export function DrawingLayer(props: {
  drawings: readonly Drawing[];
  width: number;
  height: number;
  textOf: (one: Drawing) => string;
  onChange: (one: Drawing) => void;
}) {
  const { drawings, width, height, textOf, onChange } = props;
  const layer = useRef<SVGSVGElement>(null);
  const dragged = useRef<[number, number] | null>(null);
  const place = (event: PointerEvent): Point | null => {
    const matrix = layer.current?.getScreenCTM()?.inverse();
    if (!matrix) return null;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return [at.x, at.y];
  };
  const move = (event: PointerEvent) => {
    const one = drawings.find(({ id }) => id === dragged.current?.[0]);
    const to = place(event);
    if (one && dragged.current && to) onChange(movePoint(one, dragged.current[1], to, width, height));
  };
  // The same size on the screen, whatever the size of the picture.
  const size = width / 320;
  return (
    <svg
      ref={layer}
      class="drawings"
      viewBox={`0 0 ${width} ${height}`}
      preserveAspectRatio="xMidYMid meet"
      onPointerMove={move}
      onPointerUp={() => (dragged.current = null)}
      onPointerCancel={() => (dragged.current = null)}
    >
      {drawings.map((one) => (
        <g key={one.id}>
          <polyline points={one.points.map((point) => point.join(",")).join(" ")} stroke-width={2 * size} />
          <text x={anchorOf(one)[0] + 8 * size} y={anchorOf(one)[1] - 8 * size} font-size={14 * size}>
            {textOf(one)}
          </text>
          {one.points.map(([x, y], index) => (
            <circle
              key={index}
              role="button"
              tabindex={0}
              aria-label={v("label.pointOf", { n: index + 1, text: textOf(one) })}
              cx={x}
              cy={y}
              r={5 * size}
              onPointerDown={(event) => {
                event.preventDefault();
                event.currentTarget.focus();
                layer.current?.setPointerCapture(event.pointerId);
                dragged.current = [one.id, index];
              }}
              onKeyDown={(event) => {
                const step = STEPS[event.key];
                if (!step) return;
                event.preventDefault();
                event.stopPropagation();
                const by = event.shiftKey ? 10 : 1;
                onChange(movePoint(one, index, [x + by * step[0], y + by * step[1]], width, height));
              }}
            />
          ))}
        </g>
      ))}
    </svg>
  );
}

/** Where the text of a drawing stands: at the corner of an angle, in the middle of a length. */
function anchorOf({ kind, points }: Drawing): Point {
  const [first, second] = points;
  if (!first || !second) return [0, 0];
  return kind === "angle" ? second : [(first[0] + second[0]) / 2, (first[1] + second[1]) / 2];
}

export const angleText = (one: Drawing): string => `${number(angleOf(one.points), 1)}°`;
