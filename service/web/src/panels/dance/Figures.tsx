/** A dance in figures, in plain words beside the classic blend; its transitions, each to be seen; saving and export. */
import { itemAt } from "../../lists";
import { useState } from "preact/hooks";
import { address, ask, get } from "../../api/client";
import { partOf, rowsOf, type Result } from "../../api/results";
import { note } from "../../state/session/notes";
import { AskName } from "../../ui/forms/AskName";
import { exportItems } from "../../ui/exporting/exports";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { useAsync } from "../../ui/useAsync";
import { duration, number, w } from "../../words";
import type { Bench } from "./bench";
import { nodesOf } from "./graph";
import { d } from "./words";

const BEFORE = 1; // seconds before a transition that is looked at
interface Transition {
  position: number;
  from: number;
  to: number;
  start: number;
  end: number;
  distance: number;
  foot_skate: number | null;
  classic_foot_skate: number | null;
}
interface Step {
  position: number;
  node: number;
  start: number;
  natural: boolean | null;
  distance: number | null;
}

export function Figures({ bench, result, dry }: { bench: Bench; result: Result; dry: boolean }) {
  const values = Object.fromEntries(
    rowsOf<{ metric: string; value: number | null }>(result.parts.metrics).map((one) => [one.metric, one.value]),
  );
  const warnings = rowsOf<{ warning: string }>(result.parts.warnings);
  const percent = (value?: number | null) =>
    value === null || value === undefined ? "–" : `${number(value * 100, 0)} %`;
  const sizes = (value?: number | null) =>
    value === null || value === undefined ? "–" : d("label.perSecond", { n: number(value, 3) });
  const rows: [string, string, string, string?][] = [
    ...varietyOf(values),
    [d("label.onBeat"), percent(values.grid_hits_70ms), ""],
    [d("label.alignMusic"), percent(values.beat_align_music), ""],
    [d("label.alignMotion"), percent(values.beat_align_motion), ""],
    [d("label.inside"), number(values.beats_in_transitions ?? 0), number(values.classic_beats_in_transitions ?? 0)],
    [d("label.skate"), sizes(values.foot_skate_in_transitions), sizes(values.classic_foot_skate_in_transitions)],
    [d("label.skateOutside"), sizes(values.foot_skate_outside), ""],
    [
      d("label.turning"),
      d("label.degrees", { n: number(values.greatest_rotation_speed ?? 0, 0) }),
      "",
      d("label.degrees", { n: number(values.source_greatest_rotation_speed ?? 0, 0) }),
    ],
    [d("label.moving"), sizes(values.greatest_body_speed), "", sizes(values.source_greatest_body_speed)],
    [d("label.stretch"), d("label.times", { n: number(values.greatest_rate ?? 1, 2) }), ""],
  ];
  return (
    <div class="bench-figures">
      {!dry && <Kept result={result} />}
      <p class="dim">
        {duration(values.seconds)} · {d("label.barsOf", { n: values.bars ?? 0 })} · {d("label.jumps")}:{" "}
        {number(values.jumps ?? 0)}
      </p>
      <table class="figures">
        <thead>
          <tr>
            <th>{d("label.figures")}</th>
            <th class="n">{d("label.thisDance")}</th>
            <th class="n">{d("label.classic")}</th>
            <th class="n">{d("label.sourceWord")}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(([word, own, classic, source]) => (
            <tr key={word}>
              <th scope="row">{word}</th>
              <td class="n">{own}</td>
              <td class="n dim">{classic}</td>
              <td class="n dim">{source ?? ""}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <Transitions bench={bench} result={result} dry={dry} />
      {warnings.length > 0 && (
        <details>
          <summary>{d("label.warningsWord", { n: warnings.length })}</summary>
          {warnings.map((one) => (
            <p key={one.warning} class="dim">
              {one.warning}
            </p>
          ))}
        </details>
      )}
    </div>
  );
}

/** Rows about variety and place; results of earlier versions have none. */
function varietyOf(values: Record<string, number | null | undefined>): [string, string, string][] {
  const { bars_used: used, bars_available: available, most_uses: most, farthest_from_centre: farthest } = values;
  const { least_distance: least, least_distance_at: at } = values;
  if (used == null || available == null || most == null || farthest == null) return [];
  return [
    [d("label.coverage"), d("label.ofAvailable", { used, available }), ""],
    [d("label.mostUses"), number(most), ""],
    [d("label.farthest"), d("label.metres", { n: number(farthest, 1) }), ""],
    ...(least == null
      ? []
      : [
          [d("label.leastDistance"), d("label.metresAt", { n: number(least, 2), at: number(at ?? 0, 1) }), ""] as [
            string,
            string,
            string,
          ],
        ]),
  ];
}

function Transitions({ bench, result, dry }: { bench: Bench; result: Result; dry: boolean }) {
  const steps = rowsOf<Step>(result.parts.path);
  const jumps = new Map(rowsOf<Transition>(result.parts.transitions).map((one) => [one.position, one]));
  const nodes = nodesOf(result.parts.graph ? result : (bench.graph.value ?? result), bench.documents);
  const play = (step: Step, before: Step) => {
    const player = bench.player.peek();
    if (!dry && bench.shown.peek()?.kind === "dance" && player) {
      player.pause();
      player.seek(((jumps.get(step.position)?.start ?? step.start) - BEFORE) * player.perSecond);
      player.play(1);
      return;
    }
    const [from, to] = [before, step].map((one) => nodes.find((node) => node.bar === one.node));
    if (from && to) bench.shown.value = { kind: "step", from, to };
  };
  return (
    <div class="scrolls bench-transitions" role="region" tabIndex={0} aria-label={d("label.transitions")}>
      <table>
        <thead>
          <tr>
            <th>{d("label.transitions")}</th>
            <th class="n">{d("label.when")}</th>
            <th class="n">{d("label.distance")}</th>
            <th class="n">{d("label.feet")}</th>
            <th class="n">{d("label.classic")}</th>
          </tr>
        </thead>
        <tbody>
          {steps.slice(1).map((step, at) => {
            const jump = jumps.get(step.position);
            const skate = (value?: number | null) => (value === undefined || value === null ? "" : number(value, 3));
            return (
              <tr key={step.position}>
                <td>
                  <button
                    type="button"
                    class="link"
                    aria-label={`${d("button.play")}: ${d("label.edgeOf", { from: itemAt(steps, at).node, to: step.node })}`}
                    disabled={dry && nodes.length === 0}
                    onClick={() => play(step, itemAt(steps, at))}
                  >
                    {itemAt(steps, at).node} → {step.node}
                  </button>{" "}
                  <span class={step.natural ? "dim" : "weak"}>
                    {d(step.natural ? "label.naturalWord" : "label.jump")}
                  </span>
                </td>
                <td class="n">{number(step.start, 2)} s</td>
                <td class="n">{step.natural ? "" : number(step.distance ?? 0, 3)}</td>
                <td class="n">{skate(jump?.foot_skate)}</td>
                <td class="n dim">{skate(jump?.classic_foot_skate)}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

/** Name and project of the clip that was made, its export and picture. */
function Kept({ result }: { result: Result }) {
  const [asking, setAsking] = useState(false);
  const id = partOf(result, "clip").document!;
  const clip = useAsync((signal) => get("/documents/{id}", { path: { id }, signal }), [id]);
  const [project, setProject] = useState<string | null>(null);
  const save = async (name: string) => {
    const detail = await get("/documents/{id}", { path: { id } });
    await ask("patch", "/documents/{id}", {
      path: { id },
      body: { name, project: project ?? detail.project } as never,
      match: detail.revision,
    });
    clip.again();
    note(d("label.saved", { name }), {
      action: { text: w("button.open"), run: () => location.assign(`/clips/${id}`) },
    });
  };
  return (
    <div class="row wrap">
      <strong class="cut">{clip.value?.name ?? result.name}</strong>
      <span class="dim">{clip.value?.project}</span>
      <span class="grow" />
      <button type="button" class="button primary" onClick={() => setAsking(true)}>
        {d("button.save")}…
      </button>
      <Menu
        label={d("button.exportWord")}
        side="right"
        items={exportItems(
          {
            id,
            markers: false,
            original: false,
            format: "",
            unit: clip.value?.unit ?? null,
            up: clip.value?.up ?? null,
            hasRate: true,
          },
          { give: () => location.assign(`/clips/${id}?tab=info`) },
        )}
      >
        {d("button.exportWord")}
        <Icon name="down" />
      </Menu>
      <a class="button" href={address("/results/{id}/picture", { id: result.id }, {})} target="_blank" rel="noreferrer">
        {d("label.picture")}
      </a>
      <a class="button" href={`/clips/${id}`}>
        {w("button.open")}
      </a>
      {asking && (
        <AskName
          title={d("label.saveAs")}
          initial={clip.value?.name ?? result.name}
          onName={save}
          onClose={() => setAsking(false)}
        >
          <p>
            <label class="row">
              {w("label.project")}
              <input
                class="field grow"
                value={project ?? clip.value?.project ?? ""}
                onInput={(event) => setProject(event.currentTarget.value)}
              />
            </label>
          </p>
        </AskName>
      )}
    </div>
  );
}
