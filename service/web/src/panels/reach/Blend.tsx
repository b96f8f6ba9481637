/** Sliders, and the motion that follows them: alone, beside the nearest example, or with it as a ghost. */
import { entryOf, itemAt } from "../../lists";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { ApiError } from "../../api/client";

import type { Stage } from "../../scene/stage";
import { offer } from "../../state/session/keys";
import { param, route, setParams } from "../../state/session/route";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { PlayBar } from "../../ui/playing/PlayBar";
import { Trouble } from "../../ui/Trouble";
import { number } from "../../words";
import { AttributeSlider } from "./AttributeSlider";
import { Blending } from "./blending";
import { Keep } from "./Keep";
import { valuesOf, type Model } from "./model";
import { useNearest } from "./nearest";
import { Pad } from "./Pad";
import { PhaseChart, type Curve } from "./PhaseChart";
import type { Speeds } from "./speeds";
import { Target } from "./Target";
import { TargetHandle } from "./targetHandle";
import { Trust } from "./Trust";
import { b } from "./words";

const APART = 1.1; // metres between the two bodies
const VIEWS = ["alone", "side", "ghost"] as const;
const BEHIND = 48; // examples whose curves are drawn
const LEFT_OUT = ["model", "linear", "nearest"];

export function Blend({ model, speeds }: { model: Model; speeds: Speeds | undefined }) {
  const blending = useMemo(() => new Blending(model), [model]);
  useEffect(() => {
    // What is drawn, for those who measure and test.
    Object.assign(window, { mcmlReach: blending });
    return () => blending.close();
  }, [blending]);
  useEffect(() => blending.read(), [route.value]);
  const stage = useRef<Stage | null>(null);
  const handle = useMemo(() => new TargetHandle(blending), [blending]);
  const hide = useRef<() => void>(() => {});
  useEffect(() => () => hide.current(), []);
  const { player } = blending;
  const said = param("near");
  const view = VIEWS.find((one) => one === said) ?? "ghost";
  const nearest = useNearest(blending);
  const home = () => {
    const near = blending.shown.peek()?.answer.skeleton_source.document;
    const row = near && model.byId.get(near);
    if (row) blending.set(valuesOf(model, row));
  };
  useEffect(
    () =>
      offer("reach-blend", [
        { id: "play", word: "button.play", keys: ["Space"], run: () => player.toggle() },
        { id: "nextFrame", word: "label.nextFrame", keys: ["Right", "."], run: () => player.step(1) },
        { id: "backFrame", word: "label.backFrame", keys: ["Left", ","], run: () => player.step(-1) },
        { id: "nearestExample", word: "button.toNearest", keys: ["Home"], run: home },
      ]),
    [blending],
  );
  const there = blending.shown.value !== null && nearest.settled.value;
  const body = nearest.body.value;
  const beside = view === "alone" ? null : body;
  const actors = useMemo<Actor[]>(() => {
    const first = blending.shown.peek();
    if (!first || !there) return [];
    // Sitting, it is lower than the body that limbs are drawn for.
    const skeleton = { ...first.preview.skeleton, height: body?.height ?? first.preview.skeleton.height };
    const made: Actor = {
      skeleton,
      inPlace: true,
      shift: view === "side" && beside ? -APART / 2 : 0,
      onBase: (base) => handle.stand(base),
      positions: () => {
        const { preview } = blending.shown.value!;
        player.frame.value;
        return preview.frame(Math.min(preview.frames - 1, player.at));
      },
    };
    if (!beside) return [made];
    return [
      made,
      {
        skeleton: beside,
        inPlace: true,
        dim: true,
        shift: view === "side" ? APART / 2 : 0,
        positions: () => nearest.pose(player.frame.value),
      },
    ];
  }, [there, view, beside]);
  return (
    <div class="blend">
      <section class="blend-view" aria-label={b("label.made")}>
        <div class="row wrap blend-tools">
          <div class="segments" role="group" aria-label={b("label.nearest")}>
            {VIEWS.map((one) => (
              <button key={one} type="button" aria-pressed={view === one} onClick={() => setParams({ near: one })}>
                {b(`label.${one}`)}
              </button>
            ))}
          </div>
          <NearestName model={model} blending={blending} shown={view !== "alone"} />
          <span class="grow" />
          <Took blending={blending} />
        </div>
        {actors.length ? (
          <MotionView
            actors={actors}
            puller={handle}
            label={b("label.madeOf", {
              values: model.attributes
                .map((one) => `${one.name} ${number(entryOf(blending.values.peek(), one.name), 4)}`)
                .join(", "),
            })}
            onStage={(made) => {
              stage.current = made;
              made.onDrawn = () => blending.drawn();
              hide.current();
              hide.current = handle.show(made);
              Object.assign(window, { mcmlReachStage: made });
            }}
          />
        ) : (
          <div class="blend-wait">{!blending.error.value && <div class="busy" role="presentation" />}</div>
        )}
        <PlayBar player={player} />
        <MadePhases blending={blending} speeds={speeds} model={model} />
      </section>
      <aside class="blend-side" aria-label={b("label.blend")}>
        <Head model={model} />
        <Wrong blending={blending} />
        <Sliders model={model} blending={blending} onHome={home} />
        <Target blending={blending} />
        <Trust model={model} blending={blending} />
        <TwoAtOnce model={model} blending={blending} onHome={home} />
        <Errors model={model} />
        <Keep model={model} blending={blending} picture={() => stage.current?.picture()} />
      </aside>
    </div>
  );
}

function Head({ model: { summary, result } }: { model: Model }) {
  return (
    <div>
      <h2 class="cut">{result.name}</h2>
      <p class="dim">
        {b("label.examplesOf", { n: summary.used })} · {b("label.people", { n: summary.subjects })}
        {summary.variance !== null &&
          ` · ${b("label.componentsKeep", { n: summary.components, share: number(summary.variance * 100, 0) })}`}
      </p>
    </div>
  );
}

function Wrong({ blending }: { blending: Blending }) {
  const error = blending.error.value;
  if (!error) return null;
  return (
    <Trouble
      error={error}
      retry={error instanceof ApiError && error.status === 422 ? undefined : () => blending.set({})}
    />
  );
}

function Took({ blending }: { blending: Blending }) {
  const took = blending.took.value;
  return took ? (
    <span class="dim n took">{b("label.newMotionIn", { ms: number(took, took < 10 ? 1 : 0) })}</span>
  ) : null;
}

function NearestName({ model, blending, shown }: { model: Model; blending: Blending; shown: boolean }) {
  const near = blending.shown.value?.answer.skeleton_source;
  if (!near || !shown) return null;
  return (
    <a class="cut" href={`/clips/${near.document}?rev=${near.revision}`}>
      {b("label.nearestIs", { name: model.byId.get(near.document)?.name ?? near.name })}
    </a>
  );
}

function Sliders({ model, blending, onHome }: { model: Model; blending: Blending; onHome: () => void }) {
  const values = blending.values.value;
  return (
    <div class="reach-sliders">
      {model.attributes.map((one) => (
        <AttributeSlider
          key={one.name}
          attribute={one}
          value={entryOf(values, one.name)}
          onChange={(value) => blending.set({ [one.name]: value })}
          onHome={onHome}
        />
      ))}
    </div>
  );
}

function TwoAtOnce({ model, blending, onHome }: { model: Model; blending: Blending; onHome: () => void }) {
  if (model.attributes.length < 2) return null;
  return (
    <details class="pad-fold" open>
      <summary>{b("label.twoAtOnce")}</summary>
      <Pad model={model} values={blending.values.value} onChange={(changes) => blending.set(changes)} onHome={onHome} />
    </details>
  );
}

function MadePhases({ blending, speeds, model }: { blending: Blending; speeds: Speeds | undefined; model: Model }) {
  const behind = useMemo(() => (speeds ? spread(model, speeds) : []), [speeds]);
  const [seconds, most] = useMemo(
    () => [
      Math.max(...model.used.map((one) => one.end_seconds ?? 0)) * 1.02,
      Math.max(...model.used.map((one) => one.peak_speed ?? 0)) * 1.02,
    ],
    [model],
  );
  const shown = blending.shown.value;
  const curve = useMemo(() => ({ values: shown?.answer.speed ?? [], fps: shown?.answer.fps ?? 30 }), [shown]);
  if (!shown) return <div class="phase-chart" />;
  const { t1, t2, end } = shown.answer;
  return (
    <div class="blend-phases">
      <p class="dim">{b("label.madePhases", { joint: model.summary.phase_joint })}</p>
      <PhaseChart
        curve={curve}
        times={{ t1: t1.frames, t2: t2.frames, end: end.frames }}
        seconds={Math.max(seconds, end.seconds)}
        most={most}
        behind={behind}
        player={blending.player}
        label={b("help.phasesWords", {
          t1: number(t1.seconds, 2),
          t2: number(t2.seconds, 2),
          end: number(end.seconds, 2),
        })}
      />
    </div>
  );
}

/** Curves of examples all over the set. */
function spread(model: Model, speeds: Speeds): Curve[] {
  const step = Math.max(1, model.used.length / BEHIND);
  const found: Curve[] = [];
  for (let at = 0; at < model.used.length; at += step) {
    const row = itemAt(model.used, Math.floor(at));
    const values = speeds.of(row.document);
    if (values) found.push({ values, fps: row.fps });
  }
  return found;
}

function Errors({ model: { summary } }: { model: Model }) {
  const by = summary.left_out.at(-1)?.left_out;
  const found = LEFT_OUT.map((name) =>
    summary.left_out.find((one) => one.left_out === by && one.predictor === name),
  ).filter((one) => one?.joint_degrees != null);
  const most = Math.max(...found.map((one) => one!.joint_degrees!));
  if (!found.length) return null;
  return (
    <section class="blend-errors">
      <h3>{b(by === "subject" ? "label.peopleLeftOut" : "label.clipsLeftOut")}</h3>
      {found.map((one) => (
        <div key={one!.predictor} class="bar-row">
          <span>{b(`label.by_${one!.predictor}` as "label.by_model")}</span>
          <span class="meter">
            <span class={one!.predictor} style={{ width: `${(one!.joint_degrees! / most) * 100}%` }} />
          </span>
          <span class="n">{number(one!.joint_degrees!, 2)}°</span>
        </div>
      ))}
    </section>
  );
}
