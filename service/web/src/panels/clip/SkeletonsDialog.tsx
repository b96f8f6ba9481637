/** Skeletons for the people of a marker trial: how well they fit, before they become clips of their own. */
import { useState } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import type { Clip } from "../../state/clip/clip";
import { note, refuse } from "../../state/session/notes";
import { go } from "../../state/session/route";
import { Dialog } from "../../ui/Dialog";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { r } from "./words";

const MILLIMETRES = 1000;
const FAR = 0.03; // metres from a centre that deserve a look

export function SkeletonsDialog({ clip, onClose }: { clip: Clip; onClose: () => void }) {
  const found = useAsync(
    (signal) => ask("post", "/documents/{id}/skeletons", { path: { id: clip.id }, body: { preview: true }, signal }),
    [clip.id],
  );
  const [left, setLeft] = useState<readonly string[]>([]);
  const [busy, setBusy] = useState(false);
  const people = found.value?.items ?? [];
  const chosen = people.map((one) => one.person).filter((person) => !left.includes(person));
  const make = async () => {
    setBusy(true);
    try {
      const made = await ask("post", "/documents/{id}/skeletons", {
        path: { id: clip.id },
        body: { people: chosen, preview: false },
      });
      const [first, ...others] = made.items;
      onClose();
      note(r("label.skeletonsMade", { n: made.items.length }));
      if (first?.document && !others.length) go(`/clips/${first.document}`);
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={r("button.makeSkeleton")} onClose={onClose} wide>
      <div class="skeletons">
        <p class="dim">{r("help.makeSkeleton")}</p>
        <Trouble error={found.error} />
        {!found.value && !found.error && <div class="busy" />}
        {people.map((one) => (
          <Person
            key={one.person}
            of={one}
            metres={Boolean(clip.detail.unit)}
            alone={people.length === 1}
            chosen={chosen.includes(one.person)}
            onChoose={(yes) => setLeft(yes ? left.filter((other) => other !== one.person) : [...left, one.person])}
          />
        ))}
        <div class="row export-done">
          <div class="grow" />
          <button type="button" class="button primary" disabled={busy || !chosen.length} onClick={() => void make()}>
            {busy ? w("label.loading") : r("button.makeSkeleton")}
          </button>
        </div>
      </div>
    </Dialog>
  );
}

/** metres: whether distances are in metres. alone: whether there is nobody else to choose. */
function Person({
  of,
  metres,
  alone,
  chosen,
  onChoose,
}: {
  of: Schemas["MadeSkeleton"];
  metres: boolean;
  alone: boolean;
  chosen: boolean;
  onChoose: (yes: boolean) => void;
}) {
  const distance = (value: number | null) =>
    value === null ? "–" : metres ? `${number(value * MILLIMETRES, 1)} mm` : number(value, 2);
  return (
    <section>
      {!alone && (
        <label class="row check">
          <input type="checkbox" checked={chosen} onChange={(event) => onChoose(event.currentTarget.checked)} />
          {of.person || r("label.noPrefix")}
        </label>
      )}
      <ul class="dim">
        {of.notices.map((one) => (
          <li key={one}>{one}</li>
        ))}
      </ul>
      <details class="skeletons-joints" open={alone}>
        <summary>{r("label.jointsCount", { n: of.joints.length })}</summary>
        <table>
          <thead>
            <tr>
              <th>{w("label.bone")}</th>
              <th class="n">{r("label.missMean")}</th>
              <th class="n">{w("label.largest")}</th>
              <th class="n">{r("label.framesUnknown")}</th>
            </tr>
          </thead>
          <tbody>
            {of.joints.map((joint) => (
              <tr key={joint.joint}>
                <td>{joint.joint}</td>
                <td class={`n ${metres && (joint.rms ?? 0) > FAR ? "guess" : ""}`}>{distance(joint.rms)}</td>
                <td class="n">{distance(joint.most)}</td>
                <td class={`n ${joint.unknown ? "guess" : ""}`}>{number(joint.unknown)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </details>
    </section>
  );
}
