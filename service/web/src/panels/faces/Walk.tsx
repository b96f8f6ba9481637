/** A path that is made: played on the face, moved as a cross on the map; refined into versions; saved and exported. */
import { itemAt, numberAt } from "../../lists";
import { computed, signal, type Signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { address, fetched, get, type Schemas } from "../../api/client";
import { makeMotion, resultOf, applyResult, type Result } from "../../api/results";
import { Player } from "../../state/clip/player";
import { extensionOf, isOneFile, writtenFormats, type Format } from "../../state/session/formats";
import { note, refuse } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { Menu } from "../../ui/Menu";
import { PlayBar } from "../../ui/playing/PlayBar";
import { saveBlob } from "../../ui/exporting/saveBlob";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { Icon } from "../../ui/icons";
import { number, w } from "../../words";
import { f } from "./words";
import { FaceThumb } from "./FaceThumb";
import type { Space } from "./space";

type Motion = Schemas["ExpressionMotion"];
type Path = Schemas["ExpressionPath"];
export interface Offer {
  frame: number;
  apart: number;
}

const FPS = 60;
const MOST_SAMPLES = 36_000;

/** What plays: the face, and where it is on the map; both null where nothing does. */
export interface Playing {
  face: Signal<Float32Array | null>;
  cross: Signal<[number, number] | null>;
}

/** What one motion of a face can be saved as. */
const fileItems = (save: (format: Format) => Promise<void>) =>
  writtenFormats("markers")
    .filter(isOneFile)
    .map((format) => ({ text: format.label, run: () => void save(format) }));

export function Walk({
  space,
  path,
  level,
  playing,
  onOffers,
}: {
  space: Space;
  path: Result;
  level: number;
  playing: Playing;
  onOffers: (offers: Offer[]) => void;
}) {
  const [speed, setSpeed] = useState("");
  const [loop, setLoop] = useState(false);
  const [smooth, setSmooth] = useState(false);
  const [delta, setDelta] = useState(10);
  const [busy, setBusy] = useState(false);
  const wish = {
    fps: FPS,
    loop,
    smooth,
    most_samples: MOST_SAMPLES,
    ...(Number(speed) > 0 ? { speed_mm_s: Number(speed) } : {}),
  };
  const made = useAsync(
    (stop) => makeMotion<Motion>(path.id, "playback", wish, {}, stop),
    [path.id, speed, loop, smooth],
  );
  const about = (path.parts?.path?.data.path ?? {}) as {
    version: number;
    level: number;
    keys: [string, number][];
    length_mm: number;
    bridges: number;
  };
  const keys = useMemo(() => about.keys.map(([document, frame]) => space.numberOf(document, frame)), [path, space]);
  const offered = useAsync((stop) => applyResult<Path>(path.id, "refine", { level }, {}, stop), [path.id, level]);
  const offers = useMemo<Offer[]>(
    () =>
      (offered.value?.value.offered ?? []).map((one) => ({
        frame: space.numberOf(one.document, one.frame),
        apart: one.apart_mm,
      })),
    [offered.value, space],
  );
  useEffect(() => onOffers(offers), [offers]);
  const player = useMemo(
    () => (made.value ? new Player(made.value.value.frames, made.value.value.fps) : null),
    [made.value],
  );
  const frame = useMemo(() => (player ? computed(() => player.frame.value) : signal(0)), [player]);
  useEffect(() => {
    if (!made.value || !player) return;
    const { positions, motion, value } = made.value;
    const size = numberAt(motion.shape, 1) * 3;
    const numbers = new Map<string, number>();
    const numberOf = (one: { document: string; frame: number }): number => {
      const key = `${one.document}@${one.frame}`;
      if (!numbers.has(key)) numbers.set(key, space.numberOf(one.document, one.frame));
      return numbers.get(key)!;
    };
    const face = new Float32Array(size);
    const stop = frame.subscribe((now) => {
      const shown = face.slice();
      for (let at = 0; at < size; at++)
        shown[at] = numberAt(positions, now * size + at) + numberAt(motion.origin, at % 3);
      playing.face.value = shown;
      const sample = itemAt(value.samples, Math.min(now, value.samples.length - 1));
      const [one, other] = [numberOf(sample.frame_a), numberOf(sample.frame_b)];
      playing.cross.value = [0, 1].map(
        (axis) =>
          numberAt(space.places, one * 2 + axis) * (1 - sample.alpha) +
          numberAt(space.places, other * 2 + axis) * sample.alpha,
      ) as [number, number];
    });
    player.loop.value = [0, player.frames - 1];
    player.play(1);
    performance.mark("walk-played");
    return () => {
      stop();
      player.pause();
      playing.cross.value = null;
    };
  }, [player]);
  const refine = async (more: object) => {
    setBusy(true);
    try {
      const done = await applyResult<Path>(path.id, "refine", { level, ...more });
      if (done.result) go(`/faces/${done.result}${location.search}`);
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  const save = async () => {
    try {
      const name = `${space.name}: ${f("label.pathOf")}`;
      const done = await applyResult<Motion>(path.id, "playback", wish, { save: true, name });
      note(f("label.saved", { name }), {
        action: { text: w("button.open"), run: () => go(`/clips/${done.document}`) },
      });
    } catch (error) {
      refuse(error);
    }
  };
  const download = async (format: Format) => {
    try {
      const answer = await fetched(
        address("/results/{id}/{operation}", { id: path.id, operation: "playback" }, { format: format.name }),
        {
          method: "POST",
          headers: { "content-type": "application/json" },
          body: JSON.stringify({ parameters: wish }),
        },
      );
      saveBlob(await answer.blob(), `expression-path${extensionOf(format)}`);
    } catch (error) {
      refuse(error);
    }
  };
  const seconds = made.value?.value.duration_s ?? 0;
  return (
    <section class="faces-walk" aria-label={f("label.path")}>
      {player && (
        <PlayBar player={player}>
          <span class="dim">{number(seconds, 1)} s</span>
        </PlayBar>
      )}
      <Trouble error={made.error} retry={made.again} />
      <div class="row wrap faces-save">
        <button type="button" class="button primary" disabled={!made.value} onClick={() => void save()}>
          {f("button.save")}
        </button>
        <Menu label={f("button.export")} items={() => fileItems(download)}>
          {f("button.export")}
          <Icon name="down" />
        </Menu>
        <a class="button" href={address("/results/{id}/picture", { id: path.id }, {})} target="_blank" rel="noreferrer">
          {f("label.picture")}
        </a>
        <a class="button quiet" href={`/faces/${space.id}${location.search}`}>
          {f("button.newPath")}
        </a>
      </div>
      <div class="row wrap">
        <label class="row">
          {f("label.speed")}
          <input
            class="field faces-number"
            inputMode="decimal"
            placeholder={number(made.value?.value.speed_mm_s ?? space.summary.speed_mm_s, 0)}
            value={speed}
            onChange={(event) => setSpeed(event.currentTarget.value)}
          />{" "}
          mm/s
        </label>
        <label class="row">
          <input type="checkbox" checked={loop} onChange={(event) => setLoop(event.currentTarget.checked)} />
          {f("label.loop")}
        </label>
        <label class="row">
          <input type="checkbox" checked={smooth} onChange={(event) => setSmooth(event.currentTarget.checked)} />
          {f("label.smooth")}
        </label>
      </div>
      <h3>
        {f("label.version", { n: about.version })} · {f("label.total", { mm: Math.round(about.length_mm) })}
        {about.bridges > 0 && ` · ${f("label.bridges", { n: about.bridges })}`}
      </h3>
      <ol class="faces-keys">
        {keys.map((key, at) => (
          <li key={at}>
            <button
              type="button"
              title={f("label.keyOf", { n: at + 1 })}
              onPointerEnter={() => space.want([key])}
              onClick={() => player && seekKey(player, made.value!.value, space, key)}
            >
              <FaceThumb space={space} frame={key} />
              <span>{at + 1}</span>
            </button>
          </li>
        ))}
      </ol>
      <Versions path={path} />
      <h3>
        {f("label.refine")}{" "}
        <span class="dim">
          {offered.busy ? "" : offers.length ? f("label.offered", { n: offers.length }) : f("help.noOffers")}
        </span>
      </h3>
      <Trouble error={offered.error} />
      {offers.length > 0 && (
        <ul class="faces-offers">
          {offers.slice(0, 40).map((one) => (
            <li key={one.frame}>
              <button
                type="button"
                disabled={busy}
                title={f("button.add")}
                onClick={() => void refine({ keys: [space.keyOf(one.frame)] })}
              >
                <FaceThumb space={space} frame={one.frame} />
                <span>{f("label.detour", { mm: number(one.apart, 1) })}</span>
              </button>
            </li>
          ))}
        </ul>
      )}
      <div class="row wrap">
        <button
          type="button"
          class="button"
          disabled={busy || !offers.length}
          onClick={() => void refine({ auto: true, delta: delta / 100 })}
        >
          {f("button.auto")}
        </button>
        <label class="row">
          {f("label.bound")}
          <input
            class="field faces-number"
            type="number"
            min={0}
            max={1000}
            value={delta}
            onInput={(event) => setDelta(Number(event.currentTarget.value))}
          />{" "}
          %
        </label>
      </div>
    </section>
  );
}

/** Go to where the animation passes a key. */
function seekKey(player: Player, value: Motion, space: Space, key: number): void {
  const { document, frame } = space.keyOf(key);
  const at = value.samples.findIndex(
    (one) =>
      (one.alpha < 0.5 ? one.frame_a : one.frame_b).document === document &&
      (one.alpha < 0.5 ? one.frame_a : one.frame_b).frame === frame,
  );
  player.pause();
  if (at >= 0) player.seek(at);
}

/** The versions of a path: those it was refined from, and those that were made of it. */
function Versions({ path }: { path: Result }) {
  const found = useAsync(
    async (stop) => {
      const before: Result[] = [path];
      for (let parent = path.parent; parent; parent = before[0]?.parent) {
        const above = await resultOf(parent, stop);
        if (!above.parameters.operation) break;
        before.unshift(above);
      }
      const after = (await get("/results", { query: { parent: path.id, limit: 20 }, signal: stop })).items;
      return { before, after: [...after].reverse() };
    },
    [path.id],
  );
  const versions = [...(found.value?.before ?? [path]), ...(found.value?.after ?? [])];
  if (versions.length < 2) return null;
  return (
    <nav class="row wrap faces-versions" aria-label={f("label.versions")}>
      {versions.map((one, at) => (
        <a
          key={one.id}
          class="chip"
          aria-current={one.id === path.id ? "page" : undefined}
          href={`/faces/${one.id}${location.search}`}
        >
          {f("label.version", { n: Math.min(at + 1, (found.value?.before.length ?? 1) + 1) })}
        </a>
      ))}
    </nav>
  );
}
