/** How well it fits: the bones that point elsewhere, and how feet slide. Frames in it are gone to by a press. */
import type { Schemas } from "../../api/client";
import { number, w, type Word } from "../../words";

const WORST = 4;
const CONTACTS = 12; // shown at once
const FAR = 10; // degrees, from which the server warns
const PARTS: Record<Schemas["PartError"]["part"], Word> = {
  "left arm": "label.leftArm",
  "right arm": "label.rightArm",
  "left leg": "label.leftLeg",
  "right leg": "label.rightLeg",
  hips: "label.hipLine",
  shoulders: "label.shoulderLine",
  trunk: "label.trunk",
  head: "label.headPart",
};

export function Report({
  fit,
  onFrame,
}: {
  fit: Schemas["Retargeted"];
  /** Show a frame, from 1; `last`: of a stretch that repeats. */ onFrame: (frame: number, last?: number) => void;
}) {
  const worst = [...fit.bones].sort((a, b) => b.largest - a.largest).slice(0, WORST);
  const frame = (at: number) => (
    <button type="button" class="link" aria-label={w("button.goToFrame", { n: at })} onClick={() => onFrame(at)}>
      {number(at)}
    </button>
  );
  return (
    <details class="fit-report" open>
      <summary>
        <h2>{w("label.report")}</h2>
      </summary>
      {fit.worst_frame && (
        <p>
          <button type="button" class="link" onClick={() => onFrame(fit.worst_frame!)}>
            {w("label.worstFrame", { n: fit.worst_frame })}
          </button>
        </p>
      )}
      <table>
        <thead>
          <tr>
            <th>{w("label.bone")}</th>
            <th class="n">{w("label.mean")}</th>
            <th class="n">{w("label.largest")}</th>
            <th class="n">{w("label.atFrame")}</th>
          </tr>
        </thead>
        <tbody>
          {worst.map((one) => (
            <tr key={one.bone + one.end}>
              <td>
                {one.bone} → {one.end}
              </td>
              <td class="n">{number(one.mean, 1)}°</td>
              <td class="n">{number(one.largest, 1)}°</td>
              <td class="n">{frame(one.frame)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <table>
        <thead>
          <tr>
            <th>{w("label.bodyPart")}</th>
            <th class="n">{w("label.mean")}</th>
            <th class="n">{w("label.largest")}</th>
            <th class="n">{w("label.atFrame")}</th>
          </tr>
        </thead>
        <tbody>
          {fit.parts?.map((one) => (
            <tr key={one.part}>
              <td>{w(PARTS[one.part])}</td>
              <td class={`n ${one.mean > FAR ? "guess" : ""}`}>{number(one.mean, 1)}°</td>
              <td class="n">{number(one.largest, 1)}°</td>
              <td class="n">{frame(one.frame)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {fit.feet.map(({ contacts = [], ...one }) => (
        <p key={one.foot}>
          {w("label.footSlides", { foot: one.foot, before: number(one.before, 1), after: number(one.after, 1) })}{" "}
          {contacts.slice(0, CONTACTS).map((span) => (
            <button
              key={span.first}
              type="button"
              class="chip contact"
              aria-label={w("label.contactOf", { foot: one.foot, first: span.first, last: span.last })}
              onClick={() => onFrame(span.first, span.last)}
            >
              {number(span.first)}–{number(span.last)}
            </button>
          ))}
          {contacts.length > CONTACTS && (
            <span class="dim"> {w("label.andMore", { n: contacts.length - CONTACTS })}</span>
          )}
        </p>
      ))}
      {fit.hands?.map((one) => (
        <p key={`${one.hand} ${one.other} ${one.first}`}>
          {w("label.handKept", {
            hand: one.hand,
            other: one.other,
            before: number(one.before, 1),
            after: number(one.after, 1),
          })}{" "}
          <button
            type="button"
            class="chip contact"
            aria-label={w("label.contactOf", { foot: one.hand, first: one.first, last: one.last })}
            onClick={() => onFrame(one.first, one.last)}
          >
            {number(one.first)}–{number(one.last)}
          </button>
        </p>
      ))}
      {fit.notices.map((one) => (
        <p key={one} class="dim">
          {one}
        </p>
      ))}
    </details>
  );
}
