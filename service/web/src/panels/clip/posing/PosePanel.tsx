/** The pose in the making, beside the viewer: its parts, how far they are moved, and the frames. */
import { useEffect } from "preact/hooks";
import { numberAt } from "../../../lists";
import type { Vector } from "../../../motion/body/quaternions";
import type { Clip } from "../../../state/clip/clip";
import { mustPropose, terms } from "../../../state/clip/review";
import { NumberField } from "../../../ui/forms/NumberField";
import { Icon } from "../../../ui/icons";
import { Trouble } from "../../../ui/Trouble";
import { w } from "../../../words";
import { MessageField } from "../review/MessageField";
import { editFrames, proposeFrames } from "../timeline/editFrames";
import { r } from "../words";
import { fadedRange, isStill, STILL, type HandleName } from "./handles";
import { posing, stopPosing, type Posing } from "./posing";
import { p } from "./words";
import "../../../styles/side-panel.css";
import "../../../styles/posing.css";

const AXES = ["X", "Y", "Z"] as const;

export function PosePanel({ clip, reload }: { clip: Clip; reload: () => void }) {
  useEffect(() => stopPosing, [clip]);
  const pose = posing.value;
  if (pose?.clip !== clip) return null;
  const part = pose.chosen.value;
  return (
    <aside class="side-panel pose-panel" aria-label={p("label.pose")}>
      <header class="row">
        <h2 class="grow">{p("label.pose")}</h2>
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.close")}
          title={w("button.close")}
          onClick={stopPosing}
        >
          <Icon name="close" />
        </button>
      </header>
      <p class="dim">{p("help.pose")}</p>
      <Parts pose={pose} chosen={part} />
      {part && <Ways pose={pose} part={part} />}
      <Frames pose={pose} />
      <Outcome pose={pose} />
      <Acts pose={pose} reload={reload} />
    </aside>
  );
}

function Parts({ pose, chosen }: { pose: Posing; chosen: HandleName | null }) {
  return (
    <fieldset class="pose-parts">
      <legend>{p("label.part")}</legend>
      {pose.handles.map((name) => (
        <label key={name} class="row">
          <input type="radio" name="pose-part" checked={name === chosen} onChange={() => pose.choose(name)} />
          <span class={isStill(pose.moved(name)) ? "" : "moved"}>{p(`label.part_${name}`)}</span>
        </label>
      ))}
    </fieldset>
  );
}

function Ways({ pose, part }: { pose: Posing; part: HandleName }) {
  const moved = pose.moved(part);
  const { likely_unit: unit } = pose.clip.skeleton.view;
  const rows = [
    { kind: "move", axis: "label.moveAxis", words: p("label.moveBy", { unit: unit ?? p("label.unitOfFile") }) },
    { kind: "turn", axis: "label.turnAxis", words: p("label.turnBy") },
  ] as const;
  return (
    <div class="pose-ways">
      {rows.map(({ kind, axis, words }) => (
        <div key={kind} class="pose-way" role="group" aria-label={words}>
          <span>{words}</span>
          {AXES.map((name, place) => (
            <label key={name} class="row">
              {name}
              <NumberField
                label={p(axis, { axis: name })}
                value={numberAt(moved[kind], place)}
                onChange={(value) => {
                  const next: Vector = [...moved[kind]];
                  next[place] = value ?? 0;
                  pose.set(part, { ...moved, [kind]: next });
                }}
              />
            </label>
          ))}
        </div>
      ))}
      <button type="button" class="button dense" disabled={isStill(moved)} onClick={() => pose.set(part, STILL)}>
        {p("button.resetPart")}
      </button>
    </div>
  );
}

function Frames({ pose }: { pose: Posing }) {
  const { clip } = pose;
  const [first, last] = pose.range.value;
  const rate = clip.player.perSecond;
  const [from, to] = fadedRange(pose.range.value, pose.fade.value, clip.frames);
  const inside = (value: number | null, otherwise: number) =>
    value === null ? otherwise : Math.min(clip.frames, Math.max(1, Math.round(value)));
  const setRange = (start: number, end: number) => (pose.range.value = [Math.min(start, end), Math.max(start, end)]);
  return (
    <div class="pose-frames">
      <div class="row wrap">
        <label class="row">
          {p("label.wholeFrom")}
          <NumberField
            value={first}
            least={1}
            most={clip.frames}
            step={1}
            onChange={(value) => setRange(inside(value, first), last)}
          />
        </label>
        <label class="row">
          {p("label.wholeTo")}
          <NumberField
            value={last}
            least={1}
            most={clip.frames}
            step={1}
            onChange={(value) => setRange(first, inside(value, last))}
          />
        </label>
        <label class="row">
          {p("label.fade")}
          <NumberField
            value={Number((pose.fade.value / rate).toFixed(3))}
            least={0}
            most={60}
            onChange={(value) => (pose.fade.value = Math.round(Math.min(60, Math.max(0, value ?? 0)) * rate))}
          />
        </label>
      </div>
      <label class="row">
        <input
          type="checkbox"
          checked={pose.keepFeet.value}
          onChange={(event) => (pose.keepFeet.value = event.currentTarget.checked)}
        />
        {p("label.keepFeet")}
      </label>
      <p class="dim">{p("label.changedFrames", { first: from, last: to })}</p>
      {!pose.isWhole(clip.player.frame.value) && (
        <p class="row wrap">
          <span class="dim grow">{p("help.outsidePose")}</span>
          <button type="button" class="button dense" onClick={() => clip.player.seek(first - 1)}>
            {p("button.goToPose", { n: first })}
          </button>
        </p>
      )}
    </div>
  );
}

/** What the pose does, in the server's words. */
function Outcome({ pose }: { pose: Posing }) {
  const notes = pose.seen.value?.notes ?? [];
  return (
    <>
      <Trouble error={pose.trouble.value} />
      <div role="status" aria-busy={pose.busy.value} aria-label={w("label.preview")}>
        <ul class="clean-notes">
          {!pose.edits.value && <li class="dim">{p("help.nothingMoved")}</li>}
          {notes.map((one) => (
            <li key={one}>{one}</li>
          ))}
        </ul>
      </div>
    </>
  );
}

function Acts({ pose, reload }: { pose: Posing; reload: () => void }) {
  const { clip } = pose;
  const ready = pose.edits.value !== null && pose.trouble.value === null;
  const apply = async () => {
    const edits = await pose.settled();
    if (edits) await editFrames(clip, reload, edits);
  };
  const propose = async () => {
    const edits = await pose.settled();
    if (!edits) return;
    await proposeFrames(clip, reload, edits);
    stopPosing();
  };
  return (
    <footer>
      {mustPropose() && <p class="dim">{r(terms.value.edits ? "help.reviewRequired" : "help.viewersPropose")}</p>}
      <div class="row wrap">
        <MessageField />
        <button type="button" class="button" title={r("help.propose")} disabled={!ready} onClick={() => void propose()}>
          {r("button.propose")}
        </button>
        {!mustPropose() && (
          <button type="button" class="button primary" disabled={!ready} onClick={() => void apply()}>
            {w("button.apply")}
          </button>
        )}
      </div>
    </footer>
  );
}
