/** The clips of the bench: tempo and its rivals, beats and bars, each by itself. */
import { entryOf } from "../../lists";
import { useState } from "preact/hooks";
import { refuse } from "../../state/session/notes";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { number, w } from "../../words";
import type { Bench } from "./bench";
import { ClipLane, reasonOf } from "./ClipLane";
import { MusicLane } from "./MusicLane";
import type { ClipRow } from "./rows";
import { d } from "./words";

const AT_FIRST = 30;
const REFUSED = 60; // rows of the list

export function ClipRows({ bench }: { bench: Bench }) {
  const [most, setMost] = useState(AT_FIRST);
  const rows = bench.rows.value;
  const { canUndo, canRedo } = bench.steps;
  const row = bench.row(bench.clip.value);
  const held = bench.beat.value;
  return (
    <>
      <div class="row wrap bench-tools">
        <strong class="cut">{row?.name ?? d("label.clipsWord")}</strong>
        <button
          type="button"
          class="button dense"
          disabled={!row}
          title={`${d("button.addBeat")} (B)`}
          onClick={() => row && bench.addBeat(row.id, bench.at.peek())}
        >
          {d("button.addBeat")}
        </button>
        <button
          type="button"
          class="button dense"
          disabled={!row || held < 0}
          title={`${d("button.deleteBeat")} (Del)`}
          onClick={() => row && bench.removeBeat(row.id, held)}
        >
          {d("button.deleteBeat")}
        </button>
        <button
          type="button"
          class="button dense"
          disabled={!row?.beats.some((one) => one.kind === "tracked")}
          title={`${d("button.accept")} (Shift+B)`}
          onClick={() => row && bench.accept(row.id)}
        >
          {d("button.accept")}
        </button>
        <span class="dim grow cut bench-legend" title={d("help.legend")}>
          {d("help.legend")}
        </span>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.undo")}
          title={w("button.undo")}
          disabled={!canUndo.value}
          onClick={() => bench.steps.undo()}
        >
          <Icon name="undo" />
        </button>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.redo")}
          title={w("button.redo")}
          disabled={!canRedo.value}
          onClick={() => bench.steps.redo()}
        >
          <Icon name="redo" />
        </button>
      </div>
      <Trouble error={bench.trouble.value} retry={() => bench.again()} />
      <div class="bench-busy">
        {bench.stale.value.size > 0 && (
          <div class="busy" role="status">
            <span class="unseen">{d("label.busyBeats")}</span>
          </div>
        )}
      </div>
      <div class="bench-rows" tabIndex={-1}>
        {bench.untimed.value.map((one) => (
          <Untimed key={one.id} bench={bench} {...one} />
        ))}
        {bench.unfit.value.map(({ id, why, remedy }) => (
          <p key={id} class="row wrap bench-untimed">
            <Icon name="warn" />
            <a href={`/clips/${id}`}>{why}</a>
            <span class="dim">
              {d("help.leftOut")} {remedy}
            </span>
          </p>
        ))}
        {bench.unfit.value.length > 0 && (
          <p class="bench-untimed">
            <button type="button" class="button dense" onClick={() => bench.again()}>
              {w("button.again")}
            </button>
          </p>
        )}
        {bench.music.value && <MusicLane music={bench.music.value} />}
        {rows.slice(0, most).map((one, index) => (
          <Row key={one.id} bench={bench} row={one} index={index} />
        ))}
        {rows.length > most && (
          <p>
            <button type="button" class="button dense" onClick={() => setMost(most + AT_FIRST)}>
              {d("button.moreClips", { n: rows.length - most })}
            </button>
          </p>
        )}
      </div>
      {row && <Refused bench={bench} row={row} />}
    </>
  );
}

/** A clip that is left out as long as nobody says how fast its frames follow. */
function Untimed({ bench, id, name }: { bench: Bench; id: string; name: string }) {
  const [hertz, setHertz] = useState("");
  const [busy, setBusy] = useState(false);
  const give = async () => {
    setBusy(true);
    await bench.giveRate(id, Number(hertz)).catch(refuse);
    setBusy(false);
  };
  return (
    <form
      class="row wrap bench-untimed"
      aria-label={name}
      onSubmit={(event) => {
        event.preventDefault();
        if (Number(hertz) > 0) void give();
      }}
    >
      <Icon name="warn" />
      <a href={`/clips/${id}`}>{name}</a>
      <span class="dim">{d("help.untimed")}</span>
      <label class="row">
        {d("label.rateOf")}{" "}
        <input
          class="field number"
          type="number"
          min="0"
          step="any"
          placeholder="120"
          value={hertz}
          onInput={(event) => setHertz(event.currentTarget.value)}
        />
      </label>
      <button type="submit" class="button dense primary" disabled={busy || !(Number(hertz) > 0)}>
        {w("button.apply")}
      </button>
    </form>
  );
}

function Row({ bench, row, index }: { bench: Bench; row: ClipRow; index: number }) {
  const correction = bench.steps.now.value[row.id] ?? {};
  const stale = bench.stale.value.has(row.id);
  return (
    <article class={`bench-row ${stale ? "stale" : ""}`} aria-label={row.name}>
      <header>
        <div class="row">
          <span class="swatch" style={{ background: `var(--name${index % 8})` }} />
          <a class="cut grow" href={`/clips/${row.id}`}>
            {row.name}
          </a>
          <select
            class="field dense"
            aria-label={`${d("label.from")}: ${row.name}`}
            value={correction.beats_from ?? "auto"}
            onChange={(event) =>
              bench.correct(row.id, {
                beats_from: event.currentTarget.value === "auto" ? undefined : (event.currentTarget.value as "tracked"),
                beats: undefined,
              })
            }
          >
            <option value="auto">{d("label.auto")}</option>
            <option value="detected">{d("label.detected")}</option>
            <option value="tracked">{d("label.tracked")}</option>
          </select>
        </div>
        <Tempi bench={bench} row={row} given={correction.source_bpm} />
        <span class="dim row-facts" data-bars={row.bars.length}>
          {row.bars.length ? (
            `${d("label.barsOf", { n: row.bars.length })} · ${d("label.beatsOf", { n: row.beats.length })}`
          ) : (
            <>
              {d("help.noBars", {
                f1: entryOf(row.refused, "F1"),
                f2: entryOf(row.refused, "F2"),
                f3: entryOf(row.refused, "F3"),
              })}{" "}
              {row.from !== "tracked" && (
                <button
                  type="button"
                  class="link"
                  onClick={() => bench.correct(row.id, { beats_from: "tracked", beats: undefined })}
                >
                  {d("button.useTracked")}
                </button>
              )}
            </>
          )}
        </span>
      </header>
      <ClipLane bench={bench} row={row} index={index} />
    </article>
  );
}

interface Offer {
  bpm: number;
  title: string;
  word: string;
}
const MOST_OFFERED = 4;
const isNear = (one: number, other: number, by: number) => Math.abs(one / other - 1) < by;

/** The tempo that was found, its rivals, half and double; and the one that is given, whatever was found since. */
function offersOf(row: ClipRow, given?: number): Offer[] {
  const offers: Offer[] = row.peaks.slice(0, 3).map((one) => ({
    bpm: one.bpm,
    word: "",
    title: d("label.strength", {
      bpm: number(one.bpm, 1),
      s: number(one.period, 3),
      strength: number(one.strength, 2),
    }),
  }));
  const stated = given ? [{ bpm: given, word: "", title: `${d("label.tempo")}: ${number(given, 1)}` }] : [];
  if (!offers.length) offers.push(...stated);
  const own = offers[0]?.bpm ?? 0;
  for (const [factor, word] of [
    [0.5, d("label.half")],
    [2, d("label.double")],
  ] as const) {
    const bpm = own * factor;
    // A rival may be the half or the double itself.
    if (bpm >= 25 && bpm <= 240 && !offers.some((one) => isNear(one.bpm, bpm, 0.03)))
      offers.push({ bpm, word, title: `${word}: ${number(bpm, 1)}` });
  }
  const found = offers.slice(0, MOST_OFFERED);
  return !given || found.some((one) => isNear(one.bpm, given, 0.015))
    ? found
    : [...found.slice(0, MOST_OFFERED - 1), ...stated];
}

/** A press says which tempo it was. */
function Tempi({ bench, row, given }: { bench: Bench; row: ClipRow; given?: number }) {
  // What is pressed stays as it was until it is let go, also when other tempi are found meanwhile.
  const [held, setHeld] = useState<Offer[] | null>(null);
  const offers = held ?? offersOf(row, given);
  const hold = () => {
    setHeld(offers);
    const stop = new AbortController();
    const release = () => {
      stop.abort();
      setTimeout(() => setHeld(null));
    }; // after its click
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, release, { signal: stop.signal });
  };
  const chosen = given ?? row.bpm ?? row.peaks[0]?.bpm;
  const isGiven = (one: Offer) => given !== undefined && isNear(given, one.bpm, 0.015);
  return (
    <div class="row tempi" role="group" aria-label={`${d("label.tempo")}: ${row.name}`} onPointerDown={hold}>
      {offers.map((one, place) => (
        <button
          key={place}
          type="button"
          class="chip"
          title={one.title}
          aria-label={one.title}
          aria-pressed={chosen !== undefined && isNear(chosen, one.bpm, 0.015)}
          onClick={() => bench.correct(row.id, { source_bpm: isGiven(one) ? undefined : one.bpm })}
        >
          {number(one.bpm, 1)}
          {one.word && ` ${one.word}`}
        </button>
      ))}
      {row.clear !== null && (
        <span
          class={row.clear ? "good" : "weak"}
          title={row.steady === null ? "" : d("label.steady", { n: Math.round(row.steady * 100) })}
        >
          <Icon name={row.clear ? "check" : "warn"} />
          <span class="unseen">{d(row.clear ? "label.clear" : "label.unclear")}</span>
        </span>
      )}
    </div>
  );
}

/** What is no beat, and why: for those who do not see the crosses. */
function Refused({ bench, row }: { bench: Bench; row: ClipRow }) {
  const refused = row.candidates.filter((one) => one.verdict !== "beat");
  if (!refused.length) return null;
  return (
    <details class="bench-refused">
      <summary>
        {d("label.refused", { n: refused.length })} · {row.name}
      </summary>
      <div class="scrolls" role="region" tabIndex={0} aria-label={d("label.refused", { n: refused.length })}>
        <table>
          <thead>
            <tr>
              <th class="n">{d("label.at")}</th>
              <th>{d("label.reason")}</th>
              <th class="n">{d("label.dip")}</th>
              <th class="n">{d("label.rest")}</th>
              <th>
                <span class="unseen">{d("button.take")}</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {refused.slice(0, REFUSED).map((one) => (
              <tr key={one.at}>
                <td class="n">
                  <button type="button" class="link" onClick={() => bench.go(row.id, one.at)}>
                    {number(one.at, 2)} s
                  </button>
                </td>
                <td>{reasonOf(one)}</td>
                <td class="n">{number(one.dip, 2)}</td>
                <td class="n">{number(one.rest, 2)}</td>
                <td>
                  <button
                    type="button"
                    class="button dense"
                    aria-label={`${d("button.take")}: ${number(one.at, 2)} s`}
                    onClick={() => bench.addBeat(row.id, one.at)}
                  >
                    {d("button.take")}
                  </button>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}
