/** The name of MCML's that a joint has, how sure it is, and another one in its place. */
import { useState } from "preact/hooks";
import { ask, get } from "../../../api/client";
import { itemAt } from "../../../lists";
import { isGuess } from "../../../motion/body/skeleton";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { useAsync } from "../../../ui/useAsync";
import { number } from "../../../words";
import { r } from "../words";

export function JointName({ clip, bone, reload }: { clip: Clip; bone: number; reload: () => void }) {
  const joint = itemAt(clip.skeleton.view.bones, bone);
  const [remember, setRemember] = useState(false);
  const known = useAsync((signal) => get("/joint-names", { signal }), []);
  const taken = new Set(clip.skeleton.view.bones.flatMap((one) => (one.mapped ? [one.name] : [])));
  const choose = async (name: string) => {
    try {
      const made = await ask("put", "/documents/{id}/names", {
        path: { id: clip.id },
        match: clip.detail.revision,
        body: { items: [{ joint: joint.name, name: name || null }], remember },
      });
      for (const one of made.items) note(r("label.jointRenamed", { before: one.before, after: one.after }));
      const renamed = made.items.find((one) => one.before === joint.name);
      if (renamed) clip.select([renamed.after]);
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <>
      <label class="info-row">
        <span>{r("label.jointName")}</span>
        <span class="row">
          <select
            class="field"
            disabled={clip.pinned !== null || !known.value}
            value={joint.mapped ? joint.name : ""}
            onChange={(event) => void choose(event.currentTarget.value)}
          >
            <option value="">{r("label.nameOfFile", { name: joint.source_name })}</option>
            {(known.value?.items ?? []).map(({ name }) => (
              <option key={name} value={name}>
                {taken.has(name) && name !== joint.name ? `${name} ·` : name}
              </option>
            ))}
          </select>
          {isGuess(joint) && (
            <span class="guess">{r("label.nameGuessed", { n: number(joint.confidence ?? 0, 2) })}</span>
          )}
        </span>
      </label>
      <label class="row">
        <input
          type="checkbox"
          checked={remember}
          disabled={clip.pinned !== null}
          onChange={(event) => setRemember(event.currentTarget.checked)}
        />
        {r("label.rememberName")}
      </label>
      {joint.role && (
        <div class="info-row">
          <span>{r("label.jointRole")}</span>
          <code>{joint.role}</code>
        </div>
      )}
    </>
  );
}
