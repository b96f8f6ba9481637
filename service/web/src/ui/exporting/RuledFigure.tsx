/** A pose seen from the front or the side, beside a ruler in the unit of the exported file. */
import { numberAt } from "../../lists";
import { SIDE_TOKENS, type Skeleton } from "../../motion/body/skeleton";
import { number, w } from "../../words";
import type { Ruler } from "./exportOptions";

const HEIGHT = 250; // of the picture
const ROOM = 64; // for the ruler
const EDGE = 12;

interface Figure {
  /** Of each point, from the middle and from the ground, in metres; NaN where it is not known. */
  across: number[];
  up: number[];
  top: number;
  width: number;
}

/** The pose on the plane in which it is widest. */
function figureOf(skeleton: Skeleton, positions: Float32Array, unit: number): Figure {
  const upAxis = skeleton.zUp ? 2 : 1;
  const along = (axis: number) =>
    Array.from({ length: skeleton.points }, (_, point) => numberAt(positions, point * 3 + axis) * unit);
  const extent = (values: number[]) => {
    const known = values.filter(Number.isFinite);
    return { least: Math.min(...known), most: Math.max(...known) };
  };
  const [one, two] = [along(0), along(3 - upAxis)];
  const [wide, deep] = [extent(one), extent(two)];
  const isFront = wide.most - wide.least >= deep.most - deep.least;
  const [across, span] = isFront ? [one, wide] : [two, deep];
  const up = along(upAxis);
  const { least, most } = extent(up);
  const middle = (span.least + span.most) / 2;
  return {
    across: across.map((value) => value - middle),
    up: up.map((value) => value - least),
    top: most - least,
    width: span.most - span.least,
  };
}

/** unit: metres of one of the clip. times: what the body is scaled by. ruler: null where the height is not known. */
export function RuledFigure({
  skeleton,
  positions,
  unit,
  ruler,
  metres,
  times,
}: {
  skeleton: Skeleton;
  positions: Float32Array;
  unit: number;
  ruler: Ruler | null;
  /** Of the standing body in the file. */
  metres: number;
  times: number;
}) {
  const { across, up, top, width } = figureOf(skeleton, positions, unit);
  const tall = Math.max(metres, top * times) || 1;
  const scale = (HEIGHT - 2 * EDGE) / tall;
  const x = (value: number) => ROOM + EDGE + (value * times + (width * times) / 2) * scale;
  const y = (value: number) => HEIGHT - EDGE - value * scale;
  const lines = [];
  for (let at = 0; at < skeleton.edges.length; at += 2) {
    const [from, to] = [numberAt(skeleton.edges, at), numberAt(skeleton.edges, at + 1)];
    const ends = [
      x(across[from] ?? NaN),
      y((up[from] ?? NaN) * times),
      x(across[to] ?? NaN),
      y((up[to] ?? NaN) * times),
    ];
    const [x1, y1, x2, y2] = ends;
    if (ends.every(Number.isFinite))
      lines.push(
        <line key={at} {...{ x1, y1, x2, y2 }} class={SIDE_TOKENS[numberAt(skeleton.sides, to) as 0 | 1 | 2]} />,
      );
  }
  const text = ruler ? `${number(ruler.height, ruler.height < 10 ? 2 : 0)} ${ruler.unit}` : w("label.unknown");
  const isOverMark = (mark: number) => ruler !== null && ruler.height - mark < ruler.height / 12;
  return (
    <svg
      class="ruled-figure"
      viewBox={`0 0 ${Math.max(180, ROOM + 2 * EDGE + width * times * scale)} ${HEIGHT}`}
      role="img"
      aria-label={w("label.heightInFile", { height: text })}
    >
      <line class="ground" x1={0} x2="100%" y1={y(0)} y2={y(0)} />
      {ruler?.marks.map((mark) => {
        const at = y((mark / ruler.height) * metres);
        return (
          <g key={mark}>
            <line class="mark" x1={ROOM - 8} x2={ROOM} y1={at} y2={at} />
            {!isOverMark(mark) && (
              <text x={ROOM - 12} y={at + 4} text-anchor="end">
                {number(mark, mark % 1 ? 1 : 0)}
              </text>
            )}
          </g>
        );
      })}
      {ruler && (
        <>
          <line class="mark" x1={ROOM} x2={ROOM} y1={y(0)} y2={y(metres)} />
          <line class="tall" x1={ROOM - 8} x2="100%" y1={y(metres)} y2={y(metres)} />
          <text class="tall" x={ROOM - 12} y={y(metres) + 4} text-anchor="end">
            {text}
          </text>
        </>
      )}
      {lines}
    </svg>
  );
}
