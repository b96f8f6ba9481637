/** A part of any result by its kind: a clip plays, a curve is drawn, points and graphs are spread out, tables are tables. */
import { itemAt, numberAt } from "../../lists";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { arrayOf, type Part } from "../../api/results";
import { motionOf } from "../../motion/loading/source";
import { colour, look } from "../../state/session/settings";
import { Player } from "../../state/clip/player";
import { penOf } from "../../ui/canvas";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { PlayBar } from "../../ui/playing/PlayBar";
import { Plot, type Curve } from "../../ui/Plot";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { a } from "./words";

interface AxisWords {
  name: string;
  unit?: string;
}
const MOST_ROWS = 500;
const INKS = ["accent", "name0", "name1", "name2", "name3", "name4", "name5", "name6"];

export function PartView({ id, name, part, help }: { id: string; name: string; part: Part; help: string }) {
  return (
    <div class="part">
      <h2>{name}</h2>
      {help && <p class="dim">{help}</p>}
      {part.kind === "clip" && part.document ? (
        <Clip document={part.document} />
      ) : part.kind === "curve" ? (
        <CurvePart id={id} name={name} part={part} />
      ) : part.kind === "points" ? (
        <Points id={id} name={name} part={part} />
      ) : part.kind === "graph" ? (
        <Graph part={part} />
      ) : null}
      <Table part={part} />
    </div>
  );
}

function Clip({ document }: { document: string }) {
  const motion = useAsync(() => motionOf(document), [document]);
  const found = motion.value;
  const player = useMemo(() => (found ? new Player(found.frames, found.perSecond) : null), [found]);
  useEffect(() => {
    if (!player || !found) return;
    const stop = player.frame.subscribe((frame) =>
      found.blocks.want(frame, player.playing.peek() ? 1 : 0, found.perSecond),
    );
    player.play(1);
    return () => {
      stop();
      player.pause();
    };
  }, [player]);
  const actors = useMemo<Actor[]>(
    () =>
      found && player
        ? [
            {
              skeleton: found.skeleton,
              positions: () => {
                found.blocks.arrived.value;
                return found.blocks.frame(player.frame.value);
              },
            },
          ]
        : [],
    [player],
  );
  return (
    <>
      <Trouble error={motion.error} retry={motion.again} />
      {found && player && (
        <div class="part-motion">
          <MotionView actors={actors} label={found.name} />
          <PlayBar player={player}>
            <a class="button dense" href={`/clips/${document}`}>
              {w("button.open")}
            </a>
          </PlayBar>
        </div>
      )}
    </>
  );
}

/** A curve: the arrays that its axes name; else its `series`, each with `values`. */
function CurvePart({ id, name, part }: { id: string; name: string; part: Part }) {
  const data = part.data as {
    x?: AxisWords;
    y?: AxisWords;
    series?: { name?: string; fps?: number; step?: number; values: number[] }[];
  };
  const arrays = useAsync(
    async (signal) => {
      const get = async (axis?: AxisWords) =>
        axis && part.arrays?.[axis.name] ? (await arrayOf(id, name, axis.name, { signal })).values : null;
      return { x: await get(data.x), y: await get(data.y) };
    },
    [id, name],
  );
  const drawn = useMemo(() => {
    if (data.series?.length) {
      const longest = Math.max(...data.series.map((one) => one.values.length));
      const { fps, step } = itemAt(data.series, 0);
      const along = Float64Array.from({ length: longest }, (_, at) => (fps ? (at * (step ?? 1)) / fps : at));
      const curves: Curve[] = data.series
        .slice(0, INKS.length)
        .map((one, at) => ({ name: one.name ?? String(at + 1), values: one.values, ink: INKS[at], width: 1.2 }));
      return { x: along, curves };
    }
    const values = arrays.value?.y;
    if (!values) return null;
    const x = arrays.value?.x ?? Float64Array.from({ length: values.length }, (_, at) => at + 1);
    return { x: x, curves: [{ name: data.y?.name ?? name, values: values }] };
  }, [part, arrays.value]);
  const words = (axis?: AxisWords) => (axis ? (axis.unit ? `${axis.name} [${axis.unit}]` : axis.name) : undefined);
  if (arrays.busy && !arrays.value) return <div class="busy" />;
  return drawn ? (
    <Plot x={drawn.x} curves={drawn.curves} label={name} xLabel={words(data.x)} yLabel={words(data.y)} height={280} />
  ) : (
    <p class="dim">{a("help.noArray")}</p>
  );
}

/** Points: the first array with two columns or more. */
function Points({ id, name, part }: { id: string; name: string; part: Part }) {
  const array = Object.entries(part.arrays ?? {}).find(
    ([, one]) => one.shape.length === 2 && numberAt(one.shape, 1) >= 2,
  );
  const canvas = useRef<HTMLCanvasElement>(null);
  const found = useAsync(
    async (signal) => (array ? arrayOf(id, name, array[0], { single: true, signal }) : null),
    [id, name],
  );
  useEffect(() => {
    const element = canvas.current;
    const points = found.value;
    if (!element || !points) return;
    const columns = numberAt(points.shape, 1);
    const { pen, width, height } = penOf(element);
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let row = 0; row < numberAt(points.shape, 0); row++) {
      const [x, y] = [numberAt(points.values, row * columns), numberAt(points.values, row * columns + 1)];
      if (x < left) left = x;
      if (x > right) right = x;
      if (y < low) low = y;
      if (y > high) high = y;
    }
    const scale = Math.min((width - 24) / (right - left || 1), (height - 24) / (high - low || 1));
    pen.fillStyle = colour("accent");
    pen.globalAlpha = numberAt(points.shape, 0) > 2000 ? 0.35 : 0.7;
    for (let row = 0; row < numberAt(points.shape, 0); row++) {
      pen.fillRect(
        width / 2 + (numberAt(points.values, row * columns) - (left + right) / 2) * scale - 1.5,
        height / 2 - (numberAt(points.values, row * columns + 1) - (low + high) / 2) * scale - 1.5,
        3,
        3,
      );
    }
  }, [found.value, look.value]);
  return array ? (
    <>
      <Trouble error={found.error} retry={found.again} />
      <canvas
        ref={canvas}
        class="part-points"
        role="img"
        aria-label={`${name}: ${number(numberAt(array[1].shape, 0))}`}
      />
    </>
  ) : (
    <p class="dim">{a("help.noArray")}</p>
  );
}

/** Nodes on a circle, edges between them. */
function Graph({ part }: { part: Part }) {
  const { nodes = [], edges = [] } = part.data as {
    nodes?: { id: string | number }[];
    edges?: { from: string | number; to: string | number }[];
  };
  if (!nodes.length) return null;
  const at = new Map(
    nodes.map((node, place) => {
      const angle = (2 * Math.PI * place) / nodes.length - Math.PI / 2;
      return [node.id, [Math.cos(angle), Math.sin(angle)]] as const;
    }),
  );
  const lines = edges.slice(0, 3000).flatMap((edge) => {
    const [one, other] = [at.get(edge.from), at.get(edge.to)];
    return one && other
      ? [`M${one[0].toFixed(3)} ${one[1].toFixed(3)}L${other[0].toFixed(3)} ${other[1].toFixed(3)}`]
      : [];
  });
  return (
    <svg class="part-graph" viewBox="-1.15 -1.15 2.3 2.3" role="img" aria-label={`${nodes.length} / ${edges.length}`}>
      <path d={lines.join("")} />
      {nodes.map((node) => {
        const [x, y] = at.get(node.id)!;
        return (
          <g key={node.id}>
            <circle cx={x} cy={y} r={nodes.length > 40 ? 0.015 : 0.03} />
            <title>{node.id}</title>
          </g>
        );
      })}
    </svg>
  );
}

/** Columns and rows; of other parts the plain values that they have. */
function Table({ part }: { part: Part }) {
  const columns = (part.data.columns ?? []) as { name: string; unit?: string }[];
  const plain = Object.entries(part.data).filter(([, value]) => value === null || typeof value !== "object");
  if (!columns.length && !plain.length) return null;
  const rows = columns.length ? ((part.data.rows ?? []) as unknown[][]) : plain;
  return (
    <details open={part.kind === "table"} class="part-table">
      <summary>{a("label.allValues")}</summary>
      <div class="scrolls" tabIndex={0} role="region" aria-label={a("label.allValues")}>
        <table>
          {columns.length > 0 && (
            <thead>
              <tr>
                {columns.map((one) => (
                  <th key={one.name}>
                    {one.name}
                    {one.unit ? ` [${one.unit}]` : ""}
                  </th>
                ))}
              </tr>
            </thead>
          )}
          <tbody>
            {rows.slice(0, MOST_ROWS).map((row, at) => (
              <tr key={at}>
                {row.map((value, place) => (
                  <td key={place} class={typeof value === "number" ? "n" : ""}>
                    {cell(value)}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {rows.length > MOST_ROWS && <p class="dim">{a("label.moreRows", { n: rows.length - MOST_ROWS })}</p>}
    </details>
  );
}

const DOCUMENT = /^[0-9a-f]{8}-[0-9a-f]{4}-7[0-9a-f]{3}-[0-9a-f]{4}-[0-9a-f]{12}$/;

function cell(value: unknown) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return number(value, 4);
  if (typeof value === "string" && DOCUMENT.test(value)) return <a href={`/clips/${value}`}>{value.slice(-6)}</a>;
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}
