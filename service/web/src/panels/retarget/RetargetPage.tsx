/** Motion put on another body: both side by side, the joints that belong together, how well it fits. */
import { useSignal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { subject } from "../../state/session/shell";
import { previewOf, stepFor } from "../../motion/loading/preview";
import { motionOf, type Motion } from "../../motion/loading/source";
import { demoClips } from "../../state/library/demo";
import { note, refuse } from "../../state/session/notes";
import { Player } from "../../state/clip/player";
import { go, param, setParams } from "../../state/session/route";
import { AskName } from "../../ui/forms/AskName";
import { ClipChooser } from "../../ui/clips/ClipChooser";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { EmptyState } from "../../ui/start/EmptyState";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { Many } from "./Many";
import { MappingTable, type Pair } from "./MappingTable";
import { Options, paramsOf, readChoices, type Choices } from "./Options";
import { Report } from "./Report";
import { SideBySide } from "./SideBySide";
import { skeletonIn, targetOfClip, targetOfRig, type Target } from "./target";
import "../../styles/retarget.css";

export function RetargetPage() {
  const [from, to, rig] = [param("from"), param("to"), param("rig")];
  useEffect(() => {
    subject.value = null;
  }, []);
  const source = useAsync(async () => (from ? motionOf(from) : null), [from]);
  const rigs = useAsync((signal) => get("/rigs", { signal }), []);
  const motion = useAsync(async () => (to ? motionOf(to) : null), [to]);
  const known = rigs.value?.items.find((one) => one.name === rig);
  const target = useMemo(
    () => (rig ? known && targetOfRig(known) : motion.value && targetOfClip(motion.value)),
    [rig, known, motion.value],
  );
  const error = source.error ?? motion.error ?? rigs.error;
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
          chosen={target?.name}
          known={rigs.value?.items}
          onKnown={(name) => setParams({ rig: name, to: null }, true)}
          onChoose={(id) => setParams({ to: id, rig: null }, true)}
        />
      </div>
      <Trouble error={error} />
      {source.value && target ? (
        <Fitting key={`${from} ${to} ${rig}`} source={source.value} target={target} />
      ) : from && (rig ? !rigs.value : to) ? (
        !error && <div class="busy" />
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

function Fitting({ source, target }: { source: Motion; target: Target }) {
  /** null: as the server suggests. */
  const pairs = useSignal<Pair[] | null>(null);
  const before = useSignal<(Pair[] | null)[]>([]);
  const [choices, setChoices] = useState<Choices>(readChoices);
  const [naming, setNaming] = useState(false);
  const [many, setMany] = useState(false);
  const [saving, setSaving] = useState(false);
  const selected = useSignal<string | null>(null);
  const step = stepFor(source.frames, target.points);
  const request = useMemo(
    () => ({ ...target.asked, mapping: pairs.value?.length ? pairs.value : null, ...choices }),
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
  const skeleton = useMemo(() => skeletonIn(target, seen?.motion), [target, seen]);
  const moved = useMemo(
    () => (seen?.motion && skeleton ? previewOf(seen.motion, skeleton, source.frames, source.perSecond, step) : null),
    [seen, skeleton],
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
  const shown: Pair[] =
    pairs.value ?? (seen?.matches ?? []).map(({ source: one, target: other }) => ({ source: one, target: other }));
  const joints = skeleton?.view.bones.length ?? 0;
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
      <SideBySide
        source={source}
        moved={moved}
        name={target.name}
        player={player}
        pairs={shown}
        selected={selected}
        stale={!fit.value}
        busy={fit.busy}
      />
      <aside class="retarget-map" aria-label={w("label.mapping")}>
        <div class="row wrap map-tools">
          <strong>{w("label.mappedOf", { n: shown.length, total: joints })}</strong>
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
        {skeleton && (
          <MappingTable
            source={source.skeleton}
            target={skeleton}
            pairs={shown}
            matches={seen?.matches ?? []}
            selected={selected.value}
            onSelect={(name) => (selected.value = name)}
            onChange={change}
          />
        )}
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
          <p class="dim">{w("label.mappedOf", { n: shown.length, total: joints })}</p>
        </AskName>
      )}
      {many && <Many name={target.name} request={request} onClose={() => setMany(false)} />}
    </div>
  );
}
