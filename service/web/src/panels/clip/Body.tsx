/** What can be asked of a body in motion, as a curve over the clip; a threshold on it writes the question. */
import { effect, signal } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { ask, get, type Schemas } from "../../api/client";
import { quantityOf } from "../../motion/blocks";
import { FACTS, ORIGINS, shownValue, type Fact } from "../../motion/calibration";
import { ANGLE, argumentOf, causeOf, expression, JOINT_KINDS, KINDS, known, rounded, startOf, textOf, UNITS, type Asked, type Ground, type Kind } from "../../motion/quantities";
import type { Clip } from "../../state/clip";
import { mayEdit } from "../../state/me";
import { refuse } from "../../state/notes";
import { go, param, setParams } from "../../state/route";
import { confirmFact } from "../../state/uploads";
import { colour, look } from "../../state/settings";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w, type Word } from "../../words";
import { Alike } from "./Alike";
import { inSight } from "./Timeline";

const NEAR = 10; // px from the threshold that take hold of it
const CAUSES: Record<Ground | "joints", Word> = { rate: "rateLacks", unit: "unitLacks", up: "upLacks", floor: "floorLacks", leg: "jointsLack", joints: "jointsLack" };
const WORDS: Record<Kind, Word> = { height: "quantityHeight", speed: "quantitySpeed", acceleration: "quantityAcceleration", angle: "quantityAngle", contact: "quantityContact", heading: "quantityHeading" };

export function Body({ clip, reload }: { clip: Clip; reload: () => void }) {
  const asked = startOf(param("quantity"), clip.selection.value.bones[0], clip.skeleton.view.bones.map((bone) => bone.name));
  const text = textOf(asked);
  const choose = (next: Asked) => setParams({ quantity: textOf(next) });
  const angles = useAsync((signal) => get("/xpath/complete", { query: { q: ANGLE }, signal }), []);
  const curve = useAsync((signal) => quantityOf(clip.id, clip.detail.revision, text, signal), [clip, text]);
  const [limit, setLimit] = useState<{ of: string; at: number; above: boolean } | null>(null);
  const values = curve.value;
  const span = useMemo(() => (values ? known(values) : null), [values]);
  const mine = limit?.of === text ? limit : span && { of: text, at: rounded((span.low + span.high) / 2), above: true };
  const frame = clip.player.playing.value ? clip.player.frame.peek() : clip.player.frame.value;
  const question = mine && expression(asked, mine.at, mine.above);
  const hits = values && mine ? values.reduce((sum, value) => sum + Number(asked.kind === "contact" ? value === 1 : mine.above ? value > mine.at : value < mine.at), 0) : 0;
  const loop = clip.player.loop.value;
  const [alike, setAlike] = useState<{ first: number; last?: number } | null>(null);
  const search = (q: string) => go(`/xpath?q=${encodeURIComponent(q)}`);
  const bones = clip.skeleton.view.bones.map((bone) => bone.name);
  return (
    <div class="graph">
      <div class="row wrap graph-tools">
        <select class="field" aria-label={w("quantity")} value={asked.kind} onChange={(event) => choose({ kind: event.currentTarget.value as Kind, argument: argumentOf(event.currentTarget.value as Kind, asked, bones) })}>
          {KINDS.map((kind) => <option key={kind} value={kind}>{w(WORDS[kind])}</option>)}
        </select>
        {JOINT_KINDS.has(asked.kind) && <select class="field" aria-label={w("joints")} value={asked.argument} onChange={(event) => choose({ ...asked, argument: event.currentTarget.value })}>{bones.map((name) => <option key={name}>{name}</option>)}</select>}
        {asked.kind === "angle" && <select class="field" aria-label={w("quantityAngle")} value={asked.argument} onChange={(event) => choose({ ...asked, argument: event.currentTarget.value })}>
          {[...new Set([asked.argument, ...(angles.value?.items ?? []).filter((one) => one.kind === "angle").map((one) => one.text)])].map((name) => <option key={name}>{name}</option>)}
        </select>}
        <span class="tail" />
        <button type="button" class="button" disabled={!clip.frames} title={w("posesLikeHelp")} onClick={() => setAlike({ first: frame + 1 })}>{w("posesLike")}</button>
        {loop && <button type="button" class="button" title={w("motionsLikeHelp")} onClick={() => setAlike({ first: loop[0] + 1, last: loop[1] + 1 })}>{w("motionsLike", { first: number(loop[0] + 1), last: number(loop[1] + 1) })}</button>}
      </div>
      <Trouble error={curve.error} retry={curve.again} />
      {curve.busy && !values && <div class="busy" />}
      {values && !span && <Unknown clip={clip} kind={asked.kind} reload={reload} />}
      {values && span && mine && <Curve clip={clip} values={values} label={text} unit={UNITS[asked.kind]} limit={asked.kind === "contact" ? null : mine.at} above={mine.above} onLimit={(at) => setLimit({ ...mine, at })} />}
      {values && span && mine && question && (
        <div class="curve-tools" role="group" aria-label={w("quantityAsk")}>
          <span class="row wrap">
            {asked.kind !== "contact" && <div class="segments" role="group" aria-label={w("threshold")}>
              <button type="button" aria-pressed={mine.above} onClick={() => setLimit({ ...mine, above: true })}>{w("above")}</button>
              <button type="button" aria-pressed={!mine.above} onClick={() => setLimit({ ...mine, above: false })}>{w("below")}</button>
            </div>}
            {asked.kind !== "contact" && <label class="row"><input class="field number" type="number" step="any" aria-label={w("threshold")} value={mine.at} onChange={(event) => { const at = Number(event.currentTarget.value); if (event.currentTarget.value !== "" && Number.isFinite(at)) setLimit({ ...mine, at }); }} /><span class="dim">{UNITS[asked.kind]}</span></label>}
            <span class="dim" role="status">{w("framesFound", { n: hits, all: number(clip.frames) })}</span>
          </span>
          <span class="row wrap code-line"><code>{question}</code><button type="button" class="button primary dense" onClick={() => search(question)}>{w("askLibrary")}</button></span>
        </div>
      )}
      <Calibrated clip={clip} reload={reload} />
      {alike && <Alike clip={clip} {...alike} onClose={() => setAlike(null)} />}
    </div>
  );
}

/** Why a quantity has no value, and the button that mends it. */
function Unknown({ clip, kind, reload }: { clip: Clip; kind: Kind; reload: () => void }) {
  const found = useAsync((signal) => get("/documents/{id}/calibration", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }), [clip]);
  const facts = found.value as Schemas["Calibration"] | undefined;
  if (!facts) return <Trouble error={found.error} retry={found.again} />;
  const cause = causeOf(kind, (ground) => (ground === "rate" ? Boolean(clip.detail.seconds_per_frame) : facts[ground].origin !== "unknown"));
  const likely = clip.skeleton.view.likely_unit;
  const mends = clip.pinned === null && mayEdit();
  const toFloor = () => {
    const part = document.querySelector<HTMLDetailsElement>("details.calibration");
    if (part) part.open = true;
    part?.querySelector<HTMLInputElement>(`[aria-label="${w("floor")}"]`)?.focus();
  };
  const button = (text: string, run: () => void) => mends && <button type="button" class="button primary" onClick={run}>{text}</button>;
  return (
    <div class="empty" role="status">
      <p><strong>{w(CAUSES[cause ?? "joints"])}</strong></p>
      {cause && cause !== "rate" && facts[cause].reason && <p class="dim">{facts[cause].reason}</p>}
      <p>{cause === "floor" ? button(w("setFloor"), toFloor)
        : cause === "unit" && likely && !likely.includes("/") ? button(w("confirmAs", { value: likely }), () => void confirmFact([clip.id], { unit: likely }).then((done) => done && reload()))
        : cause ? button(w(cause === "rate" ? "giveRate" : cause === "unit" ? "giveUnit" : "giveUp"), () => setParams({ tab: "info" })) : null}</p>
    </div>
  );
}

function Curve({ clip, values, label, unit, limit, above, onLimit }: { clip: Clip; values: Float64Array; label: string; unit: string; limit: number | null; above: boolean; onLimit: (at: number) => void }) {
  const host = useRef<HTMLDivElement>(null);
  const playhead = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const now = useRef({ limit, above, onLimit });
  now.current = { limit, above, onLimit };
  useEffect(() => {
    const element = host.current!;
    const follow = (self: uPlot) => {
      if (playhead.current) playhead.current.style.transform = `translateX(${self.valToPos(clip.player.frame.peek() + 1, "x") + self.over.offsetLeft}px)`;
    };
    const grid = { stroke: colour("line"), width: 1 };
    const axis = { stroke: colour("text3"), grid, ticks: grid, font: `11px ${getComputedStyle(element).fontFamily}`, size: 52 };
    const made = new uPlot({
      width: element.clientWidth, height: Math.max(160, element.clientHeight), legend: { show: false },
      scales: { x: { time: false, range: () => [inSight.peek().first + 1, Math.max(inSight.peek().first + 2, inSight.peek().last)] }, y: {} },
      axes: [{ ...axis, size: 26 }, { ...axis, label: unit || undefined, labelSize: unit ? 16 : 0, labelFont: axis.font }],
      cursor: { drag: { x: false, y: false }, points: { size: 7 } },
      series: [{}, { label, stroke: colour("accent"), width: 1.6, spanGaps: false }],
      hooks: { draw: [(self) => { follow(self); drawLimit(self, now.current.limit, now.current.above); }] },
    }, [Float64Array.from({ length: values.length }, (_, at) => at + 1), Array.from(values, (value) => (value === value ? value : null))] as never, element);
    plot.current = made;
    const observer = new ResizeObserver(() => made.setSize({ width: element.clientWidth, height: Math.max(160, element.clientHeight) }));
    observer.observe(element);
    const stops = [
      effect(() => { const { first, last } = inSight.value; made.setScale("x", { min: first + 1, max: Math.max(first + 2, last) }); }),
      effect(() => { clip.player.frame.value; follow(made); }),
    ];
    made.over.addEventListener("pointerdown", (event) => press(event, clip, made, now.current));
    return () => {
      for (const stop of stops) stop();
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [values, label, unit, look.value]);
  useEffect(() => plot.current?.redraw(false), [limit, above]);
  return <div class="graph-plot" ref={host} role="img" aria-label={label}><div ref={playhead} class="graph-playhead" /></div>;
}

/** Take hold of the threshold near the pointer, else go to the frame. */
function press(event: PointerEvent, clip: Clip, made: uPlot, now: { limit: number | null; onLimit: (at: number) => void }): void {
  const box = made.over.getBoundingClientRect();
  if (event.button) return;
  if (now.limit === null || Math.abs(made.valToPos(now.limit, "y") - (event.clientY - box.top)) > NEAR) {
    clip.player.seek(Math.max(0, Math.min(clip.frames - 1, Math.round(made.posToVal(event.clientX - box.left, "x")) - 1)));
    return;
  }
  event.preventDefault();
  const move = (moving: PointerEvent) => now.onLimit(rounded(made.posToVal(moving.clientY - box.top, "y")));
  const up = () => {
    removeEventListener("pointermove", move);
    removeEventListener("pointerup", up);
  };
  addEventListener("pointermove", move);
  addEventListener("pointerup", up);
}

/** The threshold, and the side of it that is asked for. */
function drawLimit(self: uPlot, limit: number | null, above: boolean): void {
  if (limit === null) return;
  const { ctx, bbox } = self;
  const y = Math.max(bbox.top, Math.min(bbox.top + bbox.height, self.valToPos(limit, "y", true)));
  ctx.save();
  ctx.fillStyle = colour("select");
  ctx.globalAlpha = 0.1;
  ctx.fillRect(bbox.left, above ? bbox.top : y, bbox.width, above ? y - bbox.top : bbox.top + bbox.height - y);
  ctx.globalAlpha = 1;
  ctx.strokeStyle = colour("select");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

/** Each save opens the clip anew: what was unfolded stays so. Not followed: drawn again, a field would lose what is typed. */
const calibrationOpen = signal(false);

/** What the numbers rest on; the floor and the leg can be set here, unit and up axis among the facts of the clip. */
function Calibrated({ clip, reload }: { clip: Clip; reload: () => void }) {
  const found = useAsync((signal) => get("/documents/{id}/calibration", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }), [clip]);
  const known = found.value as Schemas["Calibration"] | undefined;
  const set = async (name: "floor" | "leg", text: string) => {
    try {
      await ask("patch", "/documents/{id}/calibration", { path: { id: clip.id }, body: { [name]: text === "" ? null : Number(text) } as never, match: clip.detail.revision });
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  if (!known) return null;
  return (
    <details class="calibration" open={calibrationOpen.peek()} onToggle={(event) => (calibrationOpen.value = event.currentTarget.open)}>
      <summary>{w("calibration")}</summary>
      <p class="dim">{w("calibrationHelp")}</p>
      <table aria-label={w("calibration")}><tbody>
        {(Object.keys(FACTS) as Fact[]).map((name) => {
          const one = known[name];
          const shown = shownValue(one);
          const word = FACTS[name];
          return (
            <tr key={name}><td>{w(word)}</td>
              <td>{name === "floor" || name === "leg" ? <input class="field number" type="number" step="any" aria-label={w(word)} disabled={clip.pinned !== null} value={shown} onChange={(event) => void set(name, event.currentTarget.value)} /> : shown}</td>
              <td class="dim">{one.metres === null || one.metres === undefined || name === "unit" ? "" : `${rounded(one.metres)} m`}</td>
              <td class="dim" title={one.reason}>{w(ORIGINS[one.origin])}</td></tr>
          );
        })}
      </tbody></table>
    </details>
  );
}
