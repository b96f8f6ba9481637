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
      { name: f("label.correlation"), values: curve.r, points: "too" as const },
      { name: f("label.stress"), values: curve.stress, ink: "text3", points: "too" as const },
    ],
    [curve],
  );
  const stretch = useMemo(
    () => [{ name: f("label.stretch"), values: curve.stretch, ink: "select", points: "too" as const }],
    [curve],
  );
  return (
    <section class="faces-facts" aria-label={f("label.thisMap")}>
      <h3>{f("label.thisMap")}</h3>
      <dl>
        <dt>{f("label.frames")}</dt>
        <dd>{f("label.framesOf", { frames: summary.frames, takes: summary.takes })}</dd>
        <dt>{f("label.markersUsed")}</dt>
        <dd>
          {number(summary.markers)}
          {summary.markers_dropped.length > 0 && `, ${f("label.leftOut", { n: summary.markers_dropped.length })}`}
        </dd>
        <dt>{f("label.threshold")}</dt>
        <dd>
          {f("label.thresholdOf", { mm: number(summary.tau_mm, 0) })},{" "}
          {summary.bridges ? f("label.bridges", { n: summary.bridges }) : f("label.unbroken")}
        </dd>
        <dt>{f("label.fits")}</dt>
        <dd>
          {f("label.fitOf", { r: number(summary.r ?? 0, 3), stress: number(summary.stress ?? 0, 2) })}{" "}
          {(summary.stress ?? 0) > WEAK && <strong class="weak">{f("label.weak")}</strong>}
        </dd>
      </dl>
      {summary.warnings.map((one) => (
        <p key={one.code} class="weak">
          {one.what}
        </p>
      ))}
      {curve.x.length > 1 && (
        <details>
          <summary>{f("label.tauCurve")}</summary>
          <Plot x={curve.x} curves={curves} marks={marks} label={f("label.tauCurve")} xLabel="mm" height={150} />
          <p class="dim">{f("help.stretchHelp")}</p>
          <Plot x={curve.x} curves={stretch} marks={marks} label={f("label.stretch")} xLabel="mm" height={110} />
        </details>
      )}
      <p>
        <a
          class="button dense"
          href={address("/results/{id}/picture", { id: space.id }, {})}
          target="_blank"
          rel="noreferrer"
        >
          {f("label.picture")}
        </a>
      </p>
    </section>
  );
}
