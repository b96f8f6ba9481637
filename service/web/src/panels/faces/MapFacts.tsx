/** What one should know of a map: how many faces, the threshold and how it was chosen, how well it fits, warnings. */
import { useMemo } from "preact/hooks";
import { address } from "../../api/client";
import { Plot } from "../../ui/Plot";
import { number } from "../../words";
import { f } from "./words";
import type { Space } from "./space";

const WEAK = 0.2; // stress from which a plane shows faces on top of one another

export function MapFacts({ space }: { space: Space }) {
  const { summary } = space;
  const curve = useMemo(() => {
    const rows = [...space.tau.rows].sort((one, other) => one.tau - other.tau);
    return {
      x: rows.map((one) => one.tau),
      r: rows.map((one) => one.r),
      stress: rows.map((one) => one.stress),
      stretch: rows.map((one) => one.stretch),
    };
  }, [space]);
  const marks = useMemo(() => [{ at: space.tau.chosen, ink: "select", dash: [4, 3] }], [space]);
  const curves = useMemo(
    () => [
      { name: f("correlation"), values: curve.r, points: "too" as const },
      { name: f("stress"), values: curve.stress, ink: "text3", points: "too" as const },
    ],
    [curve],
  );
  const stretch = useMemo(
    () => [{ name: f("stretch"), values: curve.stretch, ink: "select", points: "too" as const }],
    [curve],
  );
  return (
    <section class="faces-facts" aria-label={f("thisMap")}>
      <h3>{f("thisMap")}</h3>
      <dl>
        <dt>{f("frames")}</dt>
        <dd>{f("framesOf", { frames: summary.frames, takes: summary.takes })}</dd>
        <dt>{f("markersUsed")}</dt>
        <dd>
          {number(summary.markers)}
          {summary.markers_dropped.length > 0 && `, ${f("leftOut", { n: summary.markers_dropped.length })}`}
        </dd>
        <dt>{f("threshold")}</dt>
        <dd>
          {f("thresholdOf", { mm: number(summary.tau_mm, 0) })},{" "}
          {summary.bridges ? f("bridges", { n: summary.bridges }) : f("unbroken")}
        </dd>
        <dt>{f("fits")}</dt>
        <dd>
          {f("fitOf", { r: number(summary.r ?? 0, 3), stress: number(summary.stress ?? 0, 2) })}{" "}
          {(summary.stress ?? 0) > WEAK && <strong class="weak">{f("weak")}</strong>}
        </dd>
      </dl>
      {summary.warnings.map((one) => (
        <p key={one.code} class="weak">
          {one.what}
        </p>
      ))}
      {curve.x.length > 1 && (
        <details>
          <summary>{f("tauCurve")}</summary>
          <Plot x={curve.x} curves={curves} marks={marks} label={f("tauCurve")} xLabel="mm" height={150} />
          <p class="dim">{f("stretchHelp")}</p>
          <Plot x={curve.x} curves={stretch} marks={marks} label={f("stretch")} xLabel="mm" height={110} />
        </details>
      )}
      <p>
        <a
          class="button dense"
          href={address("/results/{id}/picture", { id: space.id }, {})}
          target="_blank"
          rel="noreferrer"
        >
          {f("picture")}
        </a>
      </p>
    </section>
  );
}
