/** A small plot of a group: mean and standard deviation, with the curve of every frame range as a thin line. */
import { useEffect, useMemo, useRef } from "preact/hooks";
import { bandOf } from "../../motion/body/gait";
import { colour, look } from "../../state/session/settings";
import { number } from "../../words";
import { bandPath, BOX, extentOf, nearest, pathOf, ticksOf, xAt, yAt } from "./chart";
import { quantityName, sideName, unitName } from "./names";
import { keyOf, type Group, type Row } from "./request";
import { m } from "./words";

/** Curves that are drawn one by one. */
const MOST = 120;
const PERCENTS = [0, 25, 50, 75, 100];

export function CurvePlot({
  group,
  rows,
  picked,
  onPick,
}: {
  group: Group;
  rows: Row[];
  picked: string;
  onPick: (row: Row) => void;
}) {
  const host = useRef<SVGSVGElement>(null);
  const drawn = useMemo(() => rows.filter((row) => row.curve).slice(0, MOST), [rows]);
  const shape = useMemo(() => {
    const about = { ...group, side: "left" as const, mean: group.mean_curve, sd: group.sd_curve };
    const [low, high] = [bandOf(about, -1), bandOf(about, 1)];
    const curves = drawn.map((row) => row.curve ?? []);
    const extent = extentOf([low, high, group.mean_curve, ...curves]);
    return { low, high, curves, extent };
  }, [group, drawn]);
  useEffect(() => {
    const svg = host.current;
    if (!svg) return;
    const press = (event: MouseEvent) => {
      const scale = BOX.width / svg.clientWidth;
      const at = nearest(BOX, shape.extent, shape.curves, [event.offsetX * scale, event.offsetY * scale]);
      const row = drawn[at];
      if (row) onPick(row);
    };
    svg.addEventListener("click", press);
    return () => svg.removeEventListener("click", press);
  }, [shape, drawn, onPick]);
  const { extent } = shape;
  const side = group.group.side;
  const ink = colour(side === "left" || side === "right" ? side : "accent");
  const outliers = group.outliers ? `, ${m("label.outliers", { n: group.outliers })}` : "";
  const hidden = group.ranges > drawn.length ? `, ${m("label.hiddenCurves", { n: number(drawn.length) })}` : "";
  const chosen = drawn.find((row) => keyOf(row) === picked);
  const name = quantityName(group.quantity);
  return (
    <figure class="measure-plot" data-look={look.value}>
      <figcaption>
        <strong>{name}</strong> {group.unit && <span class="dim">({unitName(group.unit)})</span>}{" "}
        <span class="dim">{othersOf(group)}</span>
        <span class="dim block">
          {m("label.count", { n: number(group.ranges) })}
          {outliers}
          {hidden}
        </span>
      </figcaption>
      <svg
        ref={host}
        viewBox={`0 0 ${BOX.width} ${BOX.height}`}
        role="img"
        aria-label={m("label.curveOf", {
          quantity: [name, othersOf(group)].filter(Boolean).join(", "),
          n: group.ranges,
        })}
        font-size="10"
        fill={colour("text3")}
      >
        {ticksOf(extent).map((tick) => (
          <g key={tick}>
            <line
              x1={BOX.left}
              x2={BOX.width - BOX.right}
              y1={yAt(BOX, extent, tick)}
              y2={yAt(BOX, extent, tick)}
              stroke={colour("line")}
            />
            <text x={BOX.left - 5} y={yAt(BOX, extent, tick) + 3} text-anchor="end">
              {number(tick, 4)}
            </text>
          </g>
        ))}
        {PERCENTS.map((percent) => (
          <text key={percent} x={xAt(BOX, percent)} y={BOX.height - BOX.bottom + 13} text-anchor="middle">
            {percent}
          </text>
        ))}
        <text x={(BOX.left + BOX.width - BOX.right) / 2} y={BOX.height - 4} text-anchor="middle">
          {m("label.percent")}
        </text>
        {drawn.map((row, at) => (
          <path
            key={keyOf(row)}
            d={pathOf(BOX, extent, shape.curves[at] ?? [])}
            fill="none"
            stroke={colour(row.outlier ? "warn" : "text3")}
            stroke-width={row.outlier ? 1.2 : 0.7}
            stroke-opacity={row.outlier ? 0.95 : 0.5}
            stroke-dasharray={row.outlier ? "4 2" : undefined}
          />
        ))}
        <path d={bandPath(BOX, extent, shape.low, shape.high)} fill={ink} fill-opacity="0.22" />
        <path d={pathOf(BOX, extent, group.mean_curve)} fill="none" stroke={ink} stroke-width="2" />
        {chosen?.curve && (
          <path d={pathOf(BOX, extent, chosen.curve)} fill="none" stroke={colour("select")} stroke-width="2" />
        )}
      </svg>
    </figure>
  );
}

/** The values of a group besides the side that its measurement names. */
export const othersOf = (group: Group): string =>
  Object.entries(group.group)
    .filter(([key, value]) => value && !(key === "side" && group.quantity.includes(value)))
    .map(([key, value]) => (key === "side" ? sideName(value) : value))
    .join(", ");
