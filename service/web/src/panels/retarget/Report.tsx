/** How well it fits: the bones that point elsewhere, and how feet slide. */
import type { Schemas } from "../../api/client";
import { number, w } from "../../words";

const WORST = 4;

export function Report({ fit }: { fit: Schemas["Retargeted"] }) {
  const worst = [...fit.bones].sort((a, b) => b.largest - a.largest).slice(0, WORST);
  return (
    <details class="report" open>
      <summary><h3>{w("report")}</h3></summary>
      <table>
        <tbody>
          {worst.map((one) => <tr key={one.bone + one.end}><td>{one.bone} → {one.end}</td><td class="n">{number(one.mean, 1)}°</td><td class="n">≤ {number(one.largest, 1)}°</td></tr>)}
          {fit.feet.map((one) => <tr key={one.foot}><td>{w("slides", { foot: one.foot })}</td><td class="n">{number(one.before, 1)}</td><td class="n">→ {number(one.after, 1)}</td></tr>)}
        </tbody>
      </table>
      {fit.notices.map((one) => <p key={one} class="dim">{one}</p>)}
    </details>
  );
}
