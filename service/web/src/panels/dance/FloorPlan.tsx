/** The ways of several dancers on the floor, seen from above, and where each is now. The front of the stage is below. */
import { itemAt } from "../../lists";
import { useMemo } from "preact/hooks";
import { rowsOf, type Result } from "../../api/results";
import type { Player } from "../../state/clip/player";
import { number } from "../../words";
import { d } from "./words";

interface Place {
  dancer: number;
  seconds: number;
  x: number;
  z: number;
}

const MARGIN = 0.6; // metres around the ways

export function FloorPlan({ result, player }: { result: Result; player: Player | null }) {
  const ways = useMemo(() => waysOf(result), [result]);
  if (!ways.length) return null;
  const places = ways.flat();
  const stage = (result.parameters as { stage?: number | null }).stage;
  const radius = typeof stage === "number" ? stage : 0;
  const reach = (of: (place: Place) => number) => Math.max(radius, ...places.map((one) => Math.abs(of(one)))) + MARGIN;
  const [across, along] = [reach((one) => one.x), reach((one) => one.z)];
  const seconds = player ? player.frame.value / player.perSecond : 0;
  return (
    <figure class="bench-floor">
      <svg
        viewBox={`${-across} ${-along} ${2 * across} ${2 * along}`}
        role="img"
        aria-label={d("label.floor")}
        preserveAspectRatio="xMidYMid meet"
      >
        {radius > 0 && <circle class="bench-floor-stage" r={radius} />}
        {ways.map((way, at) => (
          <polyline key={at} class={`dancer-${at}`} points={way.map((one) => `${one.x},${one.z}`).join(" ")} />
        ))}
        {ways.map((way, at) => {
          const now = placeAt(way, seconds);
          return <circle key={at} class={`dancer-${at} now`} cx={now.x} cy={now.z} r={0.25} data-dancer={at + 1} />;
        })}
      </svg>
      <figcaption class="row wrap dim">
        {ways.map((_, at) => (
          <span key={at} class="row">
            <i class={`bench-dancer dancer-${at}`} />
            {d("label.dancer", { n: at + 1 })}
          </span>
        ))}
        <span>
          {number(2 * across, 1)} × {number(2 * along, 1)} m
        </span>
      </figcaption>
    </figure>
  );
}

function waysOf(result: Result): Place[][] {
  const ways = new Map<number, Place[]>();
  for (const place of rowsOf<Place>(result.parts.places)) {
    const way = ways.get(place.dancer) ?? [];
    way.push(place);
    ways.set(place.dancer, way);
  }
  return [...ways.values()];
}

/** Between the beats before and after a time. */
function placeAt(way: Place[], seconds: number): Place {
  const after = way.findIndex((one) => one.seconds > seconds);
  const next = itemAt(way, after < 0 ? way.length - 1 : after);
  const before = itemAt(way, after < 0 ? way.length - 1 : Math.max(0, after - 1));
  const step = next.seconds - before.seconds;
  const part = step > 0 ? Math.min(1, Math.max(0, (seconds - before.seconds) / step)) : 0;
  return { ...next, x: before.x + (next.x - before.x) * part, z: before.z + (next.z - before.z) * part };
}
