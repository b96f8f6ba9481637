/** The expression space: a map one walks on from face to face, coarse to fine; the walk is an animation. */
import { itemAt, numberAt } from "../../lists";
import { computed, signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { applyResult, type Result } from "../../api/results";
import { subject } from "../../state/session/shell";
import { note, refuse } from "../../state/session/notes";
import { go, param, setParams } from "../../state/session/route";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";
import { KeyFaces, type Route } from "./KeyFaces";
import { FaceView } from "./FaceView";
import { MapFacts } from "./MapFacts";
import { MapView, type OnMap } from "./MapView";
import { MOST_LINKS, openSpace, type Level, type Space } from "./space";
import { StartSpace } from "./StartSpace";
import { Walk, type Offer } from "./Walk";
import { f } from "./words";
import { Candidates } from "./Candidates";
import { Takes } from "./Takes";
import "../../styles/analyses.css";
import "../../styles/faces.css";

declare global {
  interface Window {
    mcmlFaces?: {
      face: () => number[];
      cross: () => [number, number] | null;
      number: (document: string, frame: number) => number;
    };
  }
} // candidates with a face below the map
const USUAL_LEVEL = 1;

export function FacesPage({ id }: { id: string }) {
  useEffect(() => {
    subject.value = null;
  }, [id]);
  return id ? <Opened id={id} /> : <StartSpace />;
}

function Opened({ id }: { id: string }) {
  const found = useAsync(() => openSpace(id), [id]);
  useEffect(() => {
    if (found.value) subject.value = { text: found.value.space.name };
  }, [found.value]);
  return (
    <div class="faces">
      <h1 class="unseen">{f("label.title")}</h1>
      <Trouble error={found.error} retry={found.again} />
      {found.busy && <div class="busy" />}
      {found.value && <Walked space={found.value.space} path={found.value.path} />}
    </div>
  );
}

const numbers = (text: string): number[] => text.split(",").filter(Boolean).map(Number).filter(Number.isInteger);

function Walked({ space, path }: { space: Space; path: Result | null }) {
  const last = space.counts.length - 1;
  const level = useMemo(
    () => space.level(Math.min(last, Math.max(0, Number(param("level") || USUAL_LEVEL)))),
    [space, param("level")],
  );
  const [keys, setKeys] = useState<number[]>(() =>
    path ? [] : numbers(param("keys")).filter((one) => one < space.take.length),
  );
  const [route, setRoute] = useState<Route | null>(null);
  const [offers, setOffers] = useState<Offer[]>([]);
  const [busy, setBusy] = useState(false);
  const [links, setLinks] = useState(true);
  const dimmed = useMemo(() => new Set(numbers(param("takes"))), [param("takes")]);
  const hovered = useMemo(() => signal(-1), [space]);
  const playing = useMemo(
    () => ({ face: signal<Float32Array | null>(null), cross: signal<[number, number] | null>(null) }),
    [space, path?.id],
  );
  const face = useMemo(
    () =>
      computed(() =>
        hovered.value >= 0
          ? space.face(hovered.value)
          : (playing.face.value ?? (keys.length ? space.face(keys.at(-1)!) : null)),
      ),
    [space, playing, keys],
  );
  const about = useMemo(
    () => computed(() => (hovered.value >= 0 ? f("label.shown", space.wordsOf(hovered.value)) : "")),
    [space],
  );
  const pathAbout = path?.parts?.path?.data.path as { keys: [string, number][] } | undefined;
  const walked = useMemo(
    () => pathAbout?.keys.map(([document, frame]) => space.numberOf(document, frame)) ?? [],
    [path, space],
  );
  const walk = useMemo(() => {
    const rows = (path?.parts?.path?.data.rows ?? []) as [string, number][];
    return rows.map(([document, frame]) => space.numberOf(document, frame));
  }, [path, space]);

  const change = (next: number[]) => {
    setKeys(next);
    setRoute(null);
    setParams({ keys: next.join(",") || null });
  };
  const pick = async (candidate: number) => {
    const frame = numberAt(level.candidates, candidate);
    if (path) return;
    const from = keys.length ? level.candidates.indexOf(keys.at(-1)!) : -1;
    if (from < 0) {
      change([...(keys.length ? [] : keys), frame]);
      return;
    }
    if (from === candidate) return;
    try {
      if ((await space.near(level, from)).some((one) => one.to === candidate)) {
        change([...keys, frame]);
        return;
      }
      const found = await space.route(level, from, candidate);
      setRoute(found ? { way: found.way.map((one) => numberAt(level.candidates, one)), length: found.length } : "none");
    } catch (error) {
      refuse(error);
    }
  };
  // The finest level lists no links: those of the face one stands on are asked for.
  const [, setKnown] = useState(0);
  useEffect(() => {
    const at = keys.length && !path ? level.candidates.indexOf(keys.at(-1)!) : -1;
    if (at >= 0 && !itemAt(level.neighbours, at).length)
      space.near(level, at).then(() => setKnown((before) => before + 1), refuse);
  }, [level, keys]);
  const take = () => {
    if (route && route !== "none") change([...keys, ...route.way.slice(1)]);
  };
  const choose = (next: number) => {
    const other = space.level(next);
    const kept = keys.every((key) => other.candidates.indexOf(key) >= 0);
    if (!path && keys.length && !kept) {
      const before = keys;
      change([]);
      note(f("label.levelOf", { n: other.candidates.length }), {
        action: {
          text: w("button.undo"),
          run: () => {
            setParams({ level: String(level.number) });
            change(before);
          },
        },
      });
    }
    setRoute(null);
    setParams({ level: String(next) });
  };
  const make = async () => {
    setBusy(true);
    try {
      const done = await applyResult(
        space.id,
        "path",
        { level: level.number, keys: keys.map((key) => space.keyOf(key)) },
        { name: `${space.name}: ${f("label.pathOf")}` },
      );
      go(`/faces/${done.result}?level=${Math.min(last, level.number + 1)}`);
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  const onKey = (event: KeyboardEvent) => {
    const at = keys.length ? level.candidates.indexOf(keys.at(-1)!) : -1;
    if (event.key === "Enter" && route) take();
    else if (event.key === "Backspace" && keys.length && !path) change(keys.slice(0, -1));
    else if (event.key === "Escape") setRoute(null);
    else if (event.key.startsWith("Arrow")) {
      const next = towards(space, level, at < 0 ? level.candidates.indexOf(hovered.peek()) : at, event.key);
      if (next >= 0) {
        hovered.value = numberAt(level.candidates, next);
      }
    } else if (event.key === "Enter" && hovered.peek() >= 0) {
      const candidate = level.candidates.indexOf(hovered.peek());
      if (candidate >= 0) void pick(candidate);
    } else return;
    event.preventDefault();
  };
  // What is drawn, for tests that compare it with the API.
  useEffect(() => {
    window.mcmlFaces = {
      face: () => [...(face.peek() ?? [])],
      cross: () => playing.cross.peek(),
      number: (document, frame) => space.numberOf(document, frame),
    };
  }, [face, playing, space]);
  const on = useMemo<OnMap>(
    () => ({
      level,
      keys: path ? walked : keys,
      walk: path ? walk : [],
      route: route && route !== "none" ? route.way : [],
      offers: path ? offers.map((one) => one.frame) : [],
      current: path ? -1 : (keys.at(-1) ?? -1),
      dimmed,
      links,
    }),
    [level, keys, walk, walked, route, offers, dimmed, links, path],
  );
  return (
    <div class="faces-work">
      <section class="faces-left">
        <div class="row wrap faces-tools">
          <label class="row">
            {f("label.level")}
            <input
              type="range"
              min={0}
              max={last}
              value={level.number}
              aria-valuetext={f("label.candidates", { n: level.candidates.length })}
              onInput={(event) => choose(Number(event.currentTarget.value))}
            />
          </label>
          <strong>{f("label.candidates", { n: level.candidates.length })}</strong>
          <button type="button" class="button dense" aria-pressed={links} onClick={() => setLinks(!links)}>
            {f("label.links")}
          </button>
          {level.links.a.length > MOST_LINKS && (
            <span class="dim">{f("label.linksHidden", { n: level.links.a.length })}</span>
          )}
          <span class="grow" />
          <Takes space={space} dimmed={dimmed} />
        </div>
        <MapView
          space={space}
          on={on}
          cross={playing.cross}
          onHover={(frame) => (hovered.value = frame)}
          onPick={(candidate) => void pick(candidate)}
          onKey={onKey}
        />
        {!path && (
          <Candidates
            space={space}
            level={level}
            keys={keys}
            onHover={(frame) => (hovered.value = frame)}
            onPick={(candidate) => void pick(candidate)}
          />
        )}
      </section>
      <aside class="faces-right">
        <FaceView space={space} face={face} about={about} />
        {path ? (
          <Walk key={path.id} space={space} path={path} level={level.number} playing={playing} onOffers={setOffers} />
        ) : (
          <KeyFaces
            space={space}
            keys={keys}
            route={route}
            busy={busy}
            onKeys={change}
            onRoute={take}
            onMake={() => void make()}
          />
        )}
        <MapFacts space={space} />
      </aside>
    </div>
  );
}

/** The linked candidate that lies most in a direction; -1 for none. */
function towards(space: Space, level: Level, from: number, key: string): number {
  if (from < 0) return level.candidates.length ? 0 : -1;
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key] ?? [0, 0];
  const place = (one: number, axis: number) => numberAt(space.places, numberAt(level.candidates, one) * 2 + axis);
  let [best, most] = [-1, 0.2];
  for (const { to } of itemAt(level.neighbours, from)) {
    const [dx, dy] = [place(to, 0) - place(from, 0), place(to, 1) - place(from, 1)];
    const along = (dx * numberAt(way, 0) + dy * numberAt(way, 1)) / (Math.hypot(dx, dy) || 1);
    if (along > most) [best, most] = [to, along];
  }
  return best;
}
