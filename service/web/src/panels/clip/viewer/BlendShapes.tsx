/** The blend shapes of the clip at the frame that is shown, each as a bar; over the stage, where the skeleton has any. */
import { useSignalEffect } from "@preact/signals";
import type { Clip } from "../../../state/clip/clip";
import { w } from "../../../words";

export function BlendShapes({ clip }: { clip: Clip }) {
  const { player } = clip;
  const names = clip.skeleton.view.bones.filter((bone) => bone.convention === "shape").map((bone) => bone.name);
  useSignalEffect(() => {
    if (names.length) clip.channels.want(player.frame.value, player.playing.value ? 1 : 0, player.perSecond);
  });
  if (!names.length) return null;
  clip.channels.arrived.value;
  const frame = player.frame.value;
  const selected = new Set(clip.selection.value.bones);
  return (
    <section class="blend-shapes" aria-label={w("label.blendShapes")}>
      {names.map((name) => {
        const weight = clip.sample(`${name}.weight`, frame);
        const known = weight !== null && !Number.isNaN(weight);
        return (
          <button
            key={name}
            type="button"
            class="blend-shape"
            aria-pressed={selected.has(name)}
            onClick={() => clip.select(selected.has(name) ? [] : [name])}
          >
            <span class="blend-shape-name" title={name}>
              {name}
            </span>
            <span class="blend-shape-bar">
              <i style={{ width: `${known ? Math.max(0, Math.min(1, weight)) * 100 : 0}%` }} />
            </span>
            <span class="n">{known ? weight.toFixed(2) : "–"}</span>
          </button>
        );
      })}
    </section>
  );
}
