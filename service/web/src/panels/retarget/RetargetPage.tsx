/** Motion put on another body: both side by side, the joints that belong together, how well it fits. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { subject } from "../../state/session/shell";
import { previewOf, stepFor } from "../../motion/loading/preview";
import { motionOf } from "../../motion/loading/source";
import { demoClips } from "../../state/library/demo";
import { note, refuse } from "../../state/session/notes";
import { Player } from "../../state/clip/player";
import { go, param, setParams } from "../../state/session/route";
import { AskName } from "../../ui/forms/AskName";
import { ClipChooser } from "../../ui/clips/ClipChooser";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { Scrubber } from "../../ui/playing/Scrubber";
import { EmptyState } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { Many } from "./Many";
import { MappingTable, type Pair } from "./MappingTable";
import { Options, paramsOf, readChoices, type Choices } from "./Options";
import { Report } from "./Report";
import "../../styles/retarget.css";

const APART = 1.3; // metres between the two bodies

export function RetargetPage() {
  const [from, to] = [param("from"), param("to")];
  useEffect(() => {
    subject.value = null;
  }, []);
  const source = useAsync(async () => (from ? motionOf(from) : null), [from]);
  const target = useAsync(async () => (to ? motionOf(to) : null), [to]);
  return (
    <div class="retarget">
      <h1 class="unseen">{w("label.retarget")}</h1>
      <div class="retarget-choose row wrap">
        <ClipChooser
          label={w("label.sourceClip")}
          chosen={source.value?.name}
          onChoose={(id) => setParams({ from: id }, true)}
        />
        <Icon name="right" />
        <ClipChooser
          label={w("label.targetClip")}
          chosen={target.value?.name}
          onChoose={(id) => setParams({ to: id }, true)}
        />
      </div>
      <Trouble error={source.error ?? target.error} />
      {source.value && target.value ? (
        <Fitting key={`${from} ${to}`} source={source.value} target={target.value} />
      ) : from && to ? (
        !source.error && !target.error && <div class="busy" />
      ) : (
        <EmptyState
          picture="retarget"
          title={w("button.retargetEmpty")}
          makes={w("help.retargetMakes")}
          needs={w("help.retargetHelp")}
          parts={["people"]}
          onDemo={async () => {
            const [dance, body] = await demoClips("dance_1", "wave_2");
            if (dance && body) setParams({ from: dance.id, to: body.id }, true);
          }}
        />
      )}
    </div>
  );
}

type Motion = Awaited<ReturnType<typeof motionOf>>;

function Fitting({ source, target }: { source: Motion; target: Motion }) {
  /** null: as the server suggests. */
  const pairs = useSignal<Pair[] | null>(null);
  const before = useSignal<(Pair[] | null)[]>([]);
  const [choices, setChoices] = useState<Choices>(readChoices);
  const [naming, setNaming] = useState(false);
  const [many, setMany] = useState(false);
  const [saving, setSaving] = useState(false);
  const selected = useSignal<string | null>(null);
  const step = stepFor(source.frames, target.skeleton.points);
  const request = useMemo(
    () => ({ skeleton: target.id, mapping: pairs.value?.length ? pairs.value : null, ...choices }),
    [pairs.value, choices],
  );
  const mappings = useAsync((signal) => get("/mappings", { signal }), []);
  const fit = useAsync(
    async (signal) => {
      await new Promise((resolve) => setTimeout(resolve, 150));
      signal.throwIfAborted();
      return ask("post", "/documents/{id}/retarget", {
        path: { id: source.id },
        body: { ...request, preview: true },
        query: { positions: "f4", step },
        signal,
      });
    },
    [request, source.id],
  );
  /** While a change is worked out the fit before stays, dimmed. */
  const seen = fit.value ?? fit.before;
  const moved = useMemo(
    () => (seen?.motion ? previewOf(seen.motion, target.skeleton, source.frames, source.perSecond, step) : null),
    [seen],
  );
  const player = useMemo(() => new Player(source.frames, source.perSecond), [source]);
  useEffect(() => {
    const stop = player.frame.subscribe((frame) =>
      source.blocks.want(frame, player.playing.peek() ? 1 : 0, source.perSecond),
    );
    const first = Number(param("f"));
    if (first >= 1) player.seek(first - 1);
    else player.play(1);
    return () => {
      stop();
      player.pause();
    };
  }, [player]);
  const actors = useMemo<Actor[]>(
    () => [
      {
        skeleton: source.skeleton,
        inPlace: true,
        shift: -APART / 2,
        positions: () => {
          source.blocks.arrived.value;
          return source.blocks.frame(player.frame.value);
        },
      },
      ...(moved
        ? [
            {
              skeleton: target.skeleton,
              inPlace: true,
              shift: APART / 2,
              positions: () => moved.frame(player.frame.value),
            },
          ]
        : []),
    ],
    [source, target, moved],
  );
  const marked = useMemo(
    () => ({
      get value() {
        const point = selected.value === null ? undefined : source.skeleton.byName.get(selected.value);
        return point === undefined ? [] : [point];
      },
    }),
    [source],
  );
  const shown: Pair[] =
    pairs.value ?? (seen?.matches ?? []).map(({ source: one, target: other }) => ({ source: one, target: other }));
  const change = (next: Pair[] | null) => {
    before.value = [...before.peek(), pairs.peek()];
    pairs.value = next;
  };
  const save = async () => {
    setSaving(true);
    try {
      const made = await ask("post", "/documents/{id}/retarget", {
        path: { id: source.id },
        body: { ...request, name: `${source.name} on ${target.name}` } as Schemas["RetargetRequest"],
      });
      note(w("label.retargeted", { name: `${source.name} on ${target.name}` }));
      go(`/clips/${made.document}`);
    } catch (error) {
      refuse(error);
    } finally {
      setSaving(false);
    }
  };
  const keep = async (name: string) => {
    await ask("put", "/mappings/{name}", { path: { name }, body: { pairs: shown } });
    note(w("label.savedAs", { name }));
    mappings.again();
  };
  const choose = (next: Choices) => {
    setChoices(next);
    setParams(paramsOf(next));
  };
  /** Stand at a frame, or play a stretch again and again. */
  const goTo = (first: number, last?: number) => {
    player.loop.value = last !== undefined && last > first ? [first - 1, last - 1] : null;
    player.pause();
    player.seek(first - 1);
    if (player.loop.peek()) player.play(1);
    setParams({ f: String(first) });
  };
  return (
    <div class="retarget-work">
      <section class={`retarget-view ${fit.value ? "" : "stale"}`} aria-busy={fit.busy}>
        {fit.busy && <div class="busy" />}
        <MotionView
          actors={actors}
          selected={marked as never}
          label={`${source.name}, ${target.name}`}
          onPick={(actor, point) =>
            (selected.value =
              actor === 0
                ? (source.skeleton.view.bones[point]?.name ?? null)
                : (shown.find((one) => one.target === target.skeleton.view.bones[point]?.name)?.source ?? null))
          }
        />
        <div class="transport row">
          <button
            type="button"
            class="button quiet icon play"
            aria-label={w(player.playing.value ? "button.pause" : "button.play")}
            onClick={() => {
              player.loop.value = null;
              player.toggle();
            }}
          >
            <Icon name={player.playing.value ? "pause" : "play"} />
          </button>
          <Scrubber player={player} />
        </div>
      </section>
      <aside class="retarget-map" aria-label={w("label.mapping")}>
        <div class="row wrap map-tools">
          <strong>{w("label.mappedOf", { n: shown.length, total: target.skeleton.view.bones.length })}</strong>
          <span class="grow" />
          <button
            type="button"
            class="button quiet icon dense"
            aria-label={w("button.undo")}
            disabled={!before.value.length}
            onClick={() => {
              pairs.value = before.peek().at(-1) ?? null;
              before.value = before.peek().slice(0, -1);
            }}
          >
            <Icon name="undo" />
          </button>
          <Menu
            label={w("label.mapping")}
            className="button dense"
            side="right"
            items={[
              { text: w("button.mappingName"), icon: "plus", run: () => setNaming(true) },
              ...(mappings.value?.items ?? []).map((one) => ({
                text: one.name,
                detail: one.project,
                run: () => change(one.pairs),
              })),
            ]}
          >
            {w("label.mapping")}
            <Icon name="down" />
          </Menu>
        </div>
        <Trouble error={fit.error} retry={fit.again} />
        <MappingTable
          source={source.skeleton}
          target={target.skeleton}
          pairs={shown}
          matches={seen?.matches ?? []}
          selected={selected.value}
          onSelect={(name) => (selected.value = name)}
          onChange={change}
        />
        <Options choices={choices} fitted={seen?.travel_scale} onChange={choose} />
        {fit.value && <Report fit={fit.value} onFrame={goTo} />}
        <div class="row wrap map-tools">
          <button type="button" class="button" disabled={!fit.value} onClick={() => setMany(true)}>
            {w("button.applyToMany")}
          </button>
          <span class="grow" />
          <button type="button" class="button primary" disabled={!fit.value || saving} onClick={() => void save()}>
            {saving ? w("label.retargeting") : w("button.retargetNow")}
          </button>
        </div>
      </aside>
      {naming && (
        <AskName
          title={w("button.mappingName")}
          initial={`${source.name} to ${target.name}`}
          onName={keep}
          onClose={() => setNaming(false)}
        >
          <p class="dim">{w("label.mappedOf", { n: shown.length, total: target.skeleton.view.bones.length })}</p>
        </AskName>
      )}
      {many && <Many body={target} request={request} onClose={() => setMany(false)} />}
    </div>
  );
}
