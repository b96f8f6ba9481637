/** Curves over one axis, with what is marked on them; a table says the same for those who do not see it. */
import { numberAt } from "../lists";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { colour, look } from "../state/session/settings";
import { number, w } from "../words";

export interface Curve {
  name: string;
  values: ArrayLike<number | null>;
  /** A colour of the tokens; default accent. */
  ink?: string;
  dash?: number[];
  /** Points alone, or points too. */
  points?: "only" | "too";
  width?: number;
  /** Filled between these, such as a standard deviation around the values. */
  band?: { low: ArrayLike<number | null>; high: ArrayLike<number | null> };
}
export interface Mark {
  at: number;
  ink: string;
  text?: string;
  dash?: number[];
}
export interface Zone {
  from: number;
  to: number;
  ink: string;
  alpha?: number;
  text?: string;
}

const HIDDEN = { stroke: "transparent", width: 0, points: { show: false } };

export function Plot({
  x,
  curves,
  label,
  xLabel,
  yLabel,
  marks = [],
  zones = [],
  height = 180,
  xLog = false,
  onPick,
  onReady,
}: {
  x: ArrayLike<number>;
  curves: Curve[];
  label: string;
  xLabel?: string;
  yLabel?: string;
  marks?: Mark[];
  zones?: Zone[];
  height?: number;
  xLog?: boolean;
  /** A press at a value of the axis. */
  onPick?: (at: number) => void;
  /** The plot, for tools that draw over it. */
  onReady?: (plot: uPlot) => void;
}) {
  const host = useRef<HTMLDivElement>(null);
  const drawn = useRef({ marks, zones, onPick });
  drawn.current = { marks, zones, onPick };
  const plot = useRef<uPlot | null>(null);
  useEffect(() => {
    const element = host.current!;
    const grid = { stroke: colour("line"), width: 1 };
    const axis = {
      stroke: colour("text3"),
      grid,
      ticks: grid,
      font: `11px ${getComputedStyle(element).fontFamily}`,
      size: 46,
      labelSize: 18,
      labelFont: `11px ${getComputedStyle(element).fontFamily}`,
    };
    const banded = curves.filter((one) => one.band);
    const made = new uPlot(
      {
        width: Math.max(120, element.clientWidth),
        height,
        legend: { show: false },
        scales: { x: { time: false, distr: xLog ? 3 : 1 } },
        axes: [
          { ...axis, size: 26, label: xLabel },
          { ...axis, label: yLabel },
        ],
        cursor: { drag: { x: false, y: false }, points: { size: 6 } },
        series: [
          {},
          ...curves.map((one) => ({
            label: one.name,
            stroke: colour(one.ink ?? "accent"),
            width: one.points === "only" ? 0 : (one.width ?? 1.6),
            dash: one.dash,
            spanGaps: false,
            points: one.points ? { show: true, size: 5, fill: colour(one.ink ?? "accent") } : { show: false },
          })),
          ...banded.flatMap(() => [HIDDEN, HIDDEN]),
        ],
        bands: banded.map((one, at) => ({
          series: [curves.length + 2 + 2 * at, curves.length + 1 + 2 * at] as [number, number],
          fill: `color-mix(in srgb, ${colour(one.ink ?? "accent")} 22%, transparent)`,
        })),
        hooks: {
          drawClear: [(self) => drawUnder(self, drawn.current.zones)],
          draw: [(self) => drawOver(self, drawn.current.marks)],
        },
      },
      [
        x,
        ...curves.map((one) => one.values),
        ...banded.flatMap((one) => (one.band ? [one.band.low, one.band.high] : [])),
      ] as never,
      element,
    );
    plot.current = made;
    onReady?.(made);
    const observer = new ResizeObserver(() => made.setSize({ width: Math.max(120, element.clientWidth), height }));
    observer.observe(element);
    made.over.addEventListener("click", (event) => drawn.current.onPick?.(made.posToVal(event.offsetX, "x")));
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [x, curves, look.value, height]);
  useEffect(() => plot.current?.redraw(false), [marks, zones]);
  return (
    <figure class="plot">
      <div ref={host} role="img" aria-label={label} />
      {curves.length > 1 && (
        <figcaption class="row wrap">
          {curves.map((one) => (
            <span key={one.name} class="row key">
              <span class="swatch" style={{ background: `var(--${one.ink ?? "accent"})` }} />
              {one.name}
            </span>
          ))}
        </figcaption>
      )}
      <details class="plot-table">
        <summary>{w("button.asTable")}</summary>
        <Values x={x} curves={curves} xLabel={xLabel ?? ""} />
      </details>
    </figure>
  );
}

const MOST_ROWS = 60;

/** The curves as numbers, evenly thinned. */
function Values({ x, curves, xLabel }: { x: ArrayLike<number>; curves: Curve[]; xLabel: string }) {
  const step = Math.max(1, Math.ceil(x.length / MOST_ROWS));
  const rows = Array.from({ length: Math.ceil(x.length / step) }, (_, at) => at * step);
  return (
    <table>
      <thead>
        <tr>
          <th>{xLabel}</th>
          {curves.map((one) => (
            <th key={one.name} class="n">
              {one.name}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row}>
            <td>{number(numberAt(x, row), 3)}</td>
            {curves.map((one) => (
              <td key={one.name} class="n">
                {one.values[row] === null || one.values[row] === undefined ? "–" : number(one.values[row], 4)}
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function drawUnder(self: uPlot, zones: Zone[]): void {
  const { ctx: pen, bbox } = self;
  for (const zone of zones) {
    const [from, to] = [self.valToPos(zone.from, "x", true), self.valToPos(zone.to, "x", true)];
    pen.save();
    pen.globalAlpha = zone.alpha ?? 0.14;
    pen.fillStyle = colour(zone.ink);
    pen.fillRect(from, bbox.top, to - from, bbox.height);
    pen.restore();
    if (!zone.text) continue;
    pen.fillStyle = colour("text3");
    pen.font = `${11 * devicePixelRatio}px ${getComputedStyle(self.root).fontFamily}`;
    pen.textBaseline = "top";
    pen.fillText(zone.text, from + 4 * devicePixelRatio, bbox.top + 3 * devicePixelRatio, Math.max(0, to - from - 6));
  }
}

function drawOver(self: uPlot, marks: Mark[]): void {
  const { ctx: pen, bbox } = self;
  for (const mark of marks) {
    const at = self.valToPos(mark.at, "x", true);
    pen.save();
    pen.strokeStyle = pen.fillStyle = colour(mark.ink);
    pen.lineWidth = 1.5 * devicePixelRatio;
    pen.setLineDash((mark.dash ?? []).map((one) => one * devicePixelRatio));
    pen.beginPath();
    pen.moveTo(at, bbox.top);
    pen.lineTo(at, bbox.top + bbox.height);
    pen.stroke();
    if (mark.text) {
      pen.font = `${11 * devicePixelRatio}px ${getComputedStyle(self.root).fontFamily}`;
      pen.textBaseline = "top";
      pen.fillText(mark.text, at + 3 * devicePixelRatio, bbox.top + 2 * devicePixelRatio);
    }
    pen.restore();
  }
}
