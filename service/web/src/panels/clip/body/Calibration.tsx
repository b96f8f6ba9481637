/** The facts that measures of a body rest on: unit, up axis, floor, leg. */
import { signal } from "@preact/signals";
import { ask, get } from "../../../api/client";
import { FACTS, ORIGINS, shownValue, type Fact } from "../../../motion/body/calibration";
import { rounded } from "../../../motion/body/quantities";
import type { Clip } from "../../../state/clip/clip";
import { refuse } from "../../../state/session/notes";
import { useAsync } from "../../../ui/useAsync";
import { w } from "../../../words";

/** Each save opens the clip anew: what was unfolded stays so. Not followed: drawn again, a field would lose what is typed. */
const calibrationOpen = signal(false);

/** What the numbers rest on; the floor and the leg can be set here, unit and up axis among the facts of the clip. */
export function Calibrated({ clip, reload }: { clip: Clip; reload: () => void }) {
  const found = useAsync(
    (signal) =>
      get("/documents/{id}/calibration", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }),
    [clip],
  );
  const known = found.value;
  const set = async (name: "floor" | "leg", text: string) => {
    try {
      await ask("patch", "/documents/{id}/calibration", {
        path: { id: clip.id },
        body: { [name]: text === "" ? null : Number(text) },
        match: clip.detail.revision,
      });
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  if (!known) return null;
  return (
    <details
      class="calibration"
      open={calibrationOpen.peek()}
      onToggle={(event) => (calibrationOpen.value = event.currentTarget.open)}
    >
      <summary>{w("label.calibration")}</summary>
      <p class="dim">{w("help.calibrationHelp")}</p>
      <table aria-label={w("label.calibration")}>
        <tbody>
          {(Object.keys(FACTS) as Fact[]).map((name) => {
            const one = known[name];
            const shown = shownValue(one);
            const word = FACTS[name];
            return (
              <tr key={name}>
                <td>{w(word)}</td>
                <td>
                  {name === "floor" || name === "leg" ? (
                    <input
                      class="field number"
                      type="number"
                      step="any"
                      aria-label={w(word)}
                      disabled={clip.pinned !== null}
                      value={shown}
                      onChange={(event) => void set(name, event.currentTarget.value)}
                    />
                  ) : (
                    shown
                  )}
                </td>
                <td class="dim">
                  {one.metres === null || one.metres === undefined || name === "unit" ? "" : `${rounded(one.metres)} m`}
                </td>
                <td class="dim" title={one.reason}>
                  {w(ORIGINS[one.origin])}
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </details>
  );
}
