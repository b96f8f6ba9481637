/** How well a model fits: what it says of itself, variance of components, errors of what was left out, what was tried. */
import { entryOf, numberAt } from "../../lists";
import { useMemo, useState } from "preact/hooks";
import { address } from "../../api/client";
import { arrayOf, rowsOf } from "../../api/results";
import { Icon } from "../../ui/icons";
import { Plot } from "../../ui/Plot";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import type { LeftOut, Model } from "./model";
import { isWord, nameOf, unitOf } from "./names";
import { b } from "./words";

const MOST_COMPONENTS = 40;

export function Fit({ model }: { model: Model }) {
  return (
    <div class="fit">
      <section class="fit-words">
        <Summary model={model} />
        <Picture id={model.id} />
      </section>
      <section class="fit-charts">
        <Variance model={model} />
        <Errors model={model} />
        <Tried model={model} />
      </section>
    </div>
  );
}

function Summary({ model: { summary, attributes } }: { model: Model }) {
  const mm = (value: number | null) => (value === null ? "–" : `${number(value, 0)} ${summary.hand_unit}`);
  const of = (predictor: string) => summary.left_out.findLast((one) => one.predictor === predictor);
  const [own, line, near] = ["model", "linear", "nearest"].map(of);
  const gain = own?.joint_degrees && near?.joint_degrees ? (1 - own.joint_degrees / near.joint_degrees) * 100 : null;
  return (
    <>
      <h2>{b("label.summary")}</h2>
      <p>
        {b("help.fittedTo", { n: summary.used })} {b("help.peopleMove", { n: summary.subjects })}{" "}
        {summary.excluded > 0 && b("help.leftOutClips", { n: summary.excluded })}
      </p>
      {summary.variance !== null && (
        <p>
          {b("help.keepsShare", {
            n: summary.components,
            share: number(summary.variance * 100, 0),
            error: mm(summary.reconstruction.hand),
          })}
        </p>
      )}
      {own && (
        <p>
          {b(own.left_out === "subject" ? "help.unseenPeople" : "help.unseenClips", {
            degrees: number(own.joint_degrees ?? 0, 1),
            size: mm(own.hand),
          })}{" "}
          {gain !== null && (gain > 1 ? b("help.betterThanNearest", { share: number(gain, 0) }) : b("help.notBetter"))}{" "}
          {line?.joint_degrees && own.joint_degrees && Math.abs(line.joint_degrees / own.joint_degrees - 1) < 0.02
            ? b("help.likeLine")
            : ""}
        </p>
      )}
      {attributes
        .filter((one) => one.gaps.length)
        .map((one) => (
          <p key={one.name} class="row say">
            <Icon name="warn" />
            {b("help.gapsWords", {
              name: nameOf(one.name),
              ranges: one.gaps.map(([low, high]) => `${number(low, 2)}–${number(high, 2)}`).join(", "),
              unit: unitOf(one.unit),
            })}
          </p>
        ))}
      {summary.warnings.map((one, at) => (
        <p key={at} class="row say">
          <Icon name="warn" />
          <span>
            {isWord(`help.warn_${one.code}`) ? (
              <>
                <strong>{b(`help.warn_${one.code}` as "help.warn_jump")}</strong>{" "}
                <span class="dim" lang="en">
                  {one.what}
                </span>
              </>
            ) : (
              one.what
            )}
          </span>
        </p>
      ))}
      {!summary.warnings.length && attributes.every((one) => !one.gaps.length) && (
        <p class="row say good">
          <Icon name="check" />
          {b("help.noWarnings")}
        </p>
      )}
    </>
  );
}

function Picture({ id }: { id: string }) {
  const file = (format: string) => address("/results/{id}/picture", { id }, { name: "fit", format });
  return (
    <div class="row wrap">
      <span class="dim">{w("button.picturesFor")}</span>
      {["svg", "png"].map((format) => (
        <a key={format} class="button dense" href={file(format)} download>
          <Icon name="export" />
          {format.toUpperCase()}
        </a>
      ))}
      <a class="button dense" href={`/results/${id}`}>
        {b("label.allParts")}
      </a>
    </div>
  );
}

function Variance({ model }: { model: Model }) {
  const found = useAsync(
    async (signal) => {
      const read = async (part: string) =>
        model.result.parts[part] ? (await arrayOf(model.id, part, "cumulative", { signal })).values : null;
      return Promise.all([read("variance"), read("pose_variance")]);
    },
    [model.id],
  );
  const drawn = useMemo(() => {
    const [motion, pose] = found.value ?? [null, null];
    if (!motion) return null;
    const length = Math.min(MOST_COMPONENTS, Math.max(motion.length, pose?.length ?? 0));
    const shares = (values: ArrayLike<number>) =>
      Array.from({ length }, (_, at) => (at < values.length ? numberAt(values, at) * 100 : null));
    return {
      x: Float64Array.from({ length }, (_, at) => at + 1),
      curves: [
        { name: b("label.eigenmotions"), values: shares(motion), points: "too" as const },
        ...(pose ? [{ name: b("label.eigenposes"), values: shares(pose), ink: "name1", points: "too" as const }] : []),
      ],
    };
  }, [found.value]);
  const kept = model.summary.components;
  const marks = useMemo(
    () => [{ at: kept, ink: "text2", text: b("label.keptHere", { n: kept }), dash: [3, 3] }],
    [kept],
  );
  return (
    <div class="fit-chart">
      <h3>{b("label.variance")}</h3>
      <Trouble error={found.error} retry={found.again} />
      {drawn ? (
        <Plot
          x={drawn.x}
          curves={drawn.curves}
          marks={marks}
          label={b("label.variance")}
          xLabel={b("label.componentsAxis")}
          yLabel="%"
          height={220}
        />
      ) : (
        <div class="busy" />
      )}
    </div>
  );
}

const MEASURES = ["joint", "arm", "hand", "t1", "t2", "end"] as const;

function measure(one: LeftOut, of: (typeof MEASURES)[number]): number | null {
  return of === "joint"
    ? one.joint_degrees
    : of === "arm"
      ? one.phase_joint_degrees
      : of === "hand"
        ? one.hand
        : entryOf(one.times, of);
}

function Errors({ model: { summary } }: { model: Model }) {
  const [of, setOf] = useState<(typeof MEASURES)[number]>("joint");
  const units = { joint: "°", arm: "°", hand: ` ${summary.hand_unit}`, t1: "", t2: "", end: "" };
  const groups = [...new Set(summary.left_out.map((one) => one.left_out))];
  const most = Math.max(1e-9, ...summary.left_out.map((one) => measure(one, of) ?? 0));
  return (
    <div class="fit-chart">
      <h3>{b("label.leftOutErrors")}</h3>
      <div class="segments" role="group" aria-label={b("label.errorOf")}>
        {MEASURES.map((one) => (
          <button key={one} type="button" aria-pressed={one === of} onClick={() => setOf(one)}>
            {b(`label.of_${one}`)}
          </button>
        ))}
      </div>
      {groups.map((group) => (
        <div key={group} class="error-group">
          <p class="dim">{b(group === "subject" ? "label.peopleLeftOut" : "label.clipsLeftOut")}</p>
          {summary.left_out
            .filter((one) => one.left_out === group)
            .map((one) => {
              const value = measure(one, of);
              return (
                <div key={one.predictor} class="bar-row">
                  <span>{b(`label.by_${one.predictor}` as "label.by_model")}</span>
                  <span class="meter">
                    <span class={one.predictor} style={{ width: `${((value ?? 0) / most) * 100}%` }} />
                  </span>
                  <span class="n">{value === null ? "–" : `${number(value, 2)}${units[of]}`}</span>
                </div>
              );
            })}
        </div>
      ))}
      <p class="dim">
        {b(of === "joint" || of === "arm" ? "help.degreesHelp" : of === "hand" ? "help.handHelp" : "help.framesHelp")}
      </p>
    </div>
  );
}

const WORSE = 0.1; // than the least error, from which on a pair is not tinted

interface Try {
  of: string;
  s: number;
  lam: number;
  condition: number | null;
  error: number | null;
}

/** Widths across, ridges down: the error of each pair, the one that was taken outlined. */
function Tried({ model }: { model: Model }) {
  const [of, setOf] = useState<"motion" | "times">("motion");
  const all = useMemo(() => rowsOf<Try>(model.result.parts.selection), [model]);
  const rows = all.filter((one) => one.of === of);
  if (!all.length) return null;
  const widths = [...new Set(rows.map((one) => one.s))].sort((one, other) => one - other);
  const ridges = [...new Set(rows.map((one) => one.lam))].sort((one, other) => one - other);
  const known = rows.flatMap((one) => (one.error === null ? [] : [one.error]));
  const least = Math.min(...known);
  const { summary } = model;
  const taken = of === "motion" ? [summary.s, summary.lam] : [summary.time_s, summary.time_lam];
  return (
    <div class="fit-chart">
      <h3>{b("label.tried")}</h3>
      <div class="segments" role="group" aria-label={b("label.tried")}>
        {(["motion", "times"] as const).map((one) => (
          <button key={one} type="button" aria-pressed={one === of} onClick={() => setOf(one)}>
            {b(`label.tried_${one}`)}
          </button>
        ))}
      </div>
      <div class="scrolls" tabIndex={0} role="group" aria-label={b("label.tried")}>
        <table class="tried">
          <thead>
            <tr>
              <th scope="col">λ \ s</th>
              {widths.map((one) => (
                <th key={one} scope="col" class="n">
                  {number(one, 3)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {ridges.map((lam) => (
              <tr key={lam}>
                <th scope="row" class="n">
                  {number(lam, 5)}
                </th>
                {widths.map((s) => {
                  const found = rows.find((one) => one.s === s && one.lam === lam);
                  const share = found?.error == null ? 0 : Math.max(0, 1 - (found.error / least - 1) / WORSE);
                  const chosen = s === taken[0] && lam === taken[1];
                  return (
                    <td
                      key={s}
                      class={`n ${chosen ? "taken" : ""}`}
                      style={{ "--share": `${(share * 34).toFixed(0)}%` }}
                    >
                      {found?.error == null ? "–" : number(found.error, 3)}
                    </td>
                  );
                })}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p class="dim">{b("help.triedHelp", { s: number(numberAt(taken, 0), 3), lam: number(numberAt(taken, 1), 4) })}</p>
    </div>
  );
}
