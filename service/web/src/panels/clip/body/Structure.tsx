/** The hierarchy as a picture of nodes and links. A bone's offset and length are changed below it. */
import { itemAt, numberAt } from "../../../lists";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { tidy } from "../../../motion/body/hierarchy";
import type { Vector } from "../../../motion/body/quaternions";
import { vectorOf } from "../../../motion/body/shape";
import { isGuess, SIDE_TOKENS, type Bone } from "../../../motion/body/skeleton";
import type { Clip } from "../../../state/clip/clip";
import { dockWide } from "../../../state/session/panes";
import { number, w } from "../../../words";
import { r } from "../words";
import { JointName } from "./JointName";

const LEVEL_LEAST = 34;
const LEVEL_MOST = 74;
const NAMES = 136; // px for the names of leaves
const LEAF = 26;

export function Structure({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { skeleton } = clip;
  const { bones } = skeleton.view;
  const layout = useMemo(() => tidy(bones.map((bone) => bone.parent)), [clip]);
  const box = useRef<HTMLDivElement>(null);
  const level = Math.max(LEVEL_LEAST, Math.min(LEVEL_MOST, (dockWide.value - NAMES) / layout.width));
  const selected = clip.selection.value.bones;
  const at = selected.length ? skeleton.byName.get(itemAt(selected, 0)) : undefined;
  useEffect(() => {
    box.current?.querySelector(".chosen")?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }, [at]);
  const place = (index: number) => ({
    x: 14 + itemAt(layout.places, index).x * level,
    y: 26 + itemAt(layout.places, index).y * LEAF,
  });
  const onKey = (event: KeyboardEvent) => {
    const here = at ?? 0;
    const family = bones
      .map((_, index) => index)
      .filter((index) => itemAt(bones, index).parent === itemAt(bones, here).parent);
    const to = {
      ArrowLeft: itemAt(bones, here).parent,
      ArrowRight: bones.findIndex((bone) => bone.parent === here),
      ArrowUp: family[family.indexOf(here) - 1],
      ArrowDown: family[family.indexOf(here) + 1],
    }[event.key];
    if (to === undefined || to < 0) return;
    clip.select([itemAt(bones, to).name]);
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div class="structure">
      <div
        ref={box}
        class="structure-scroll"
        tabIndex={0}
        role="tree"
        aria-label={w("label.structure")}
        aria-activedescendant={at === undefined ? undefined : `node-${at}`}
        onKeyDown={onKey}
      >
        <svg width={layout.width * level + NAMES - 14} height={layout.height * LEAF + 40}>
          {bones.map((bone, index) => {
            if (bone.parent < 0) return null;
            const [from, to] = [place(bone.parent), place(index)];
            return (
              <path
                key={index}
                d={`M${from.x},${from.y}C${from.x + level * 0.55},${from.y} ${to.x - level * 0.55},${to.y} ${to.x},${to.y}`}
                fill="none"
                stroke={`var(--${SIDE_TOKENS[numberAt(skeleton.sides, index)]})`}
                stroke-opacity="0.55"
                stroke-width="1.5"
              />
            );
          })}
          {bones.map((bone, index) => {
            const { x, y } = place(index);
            const leaf = !bones.some((other) => other.parent === index);
            const chosen = selected.includes(bone.name);
            return (
              <g
                key={index}
                id={`node-${index}`}
                role="treeitem"
                aria-label={bone.name}
                aria-selected={chosen}
                class={`node ${chosen ? "chosen" : ""}`}
                onClick={(event) =>
                  clip.select(event.ctrlKey || event.shiftKey ? [...selected, bone.name] : [bone.name])
                }
              >
                <circle cx={x} cy={y} r="10" fill="transparent" />
                <Dot bone={bone} x={x} y={y} ink={`var(--${SIDE_TOKENS[numberAt(skeleton.sides, index)]})`} />
                {chosen && <circle cx={x} cy={y} r="8" fill="none" stroke="var(--select)" stroke-width="2" />}
                {(leaf || chosen || at === undefined) && (
                  <text
                    x={leaf ? x + 10 : x}
                    y={leaf ? y + 4 : y - 9}
                    text-anchor={leaf ? "start" : "middle"}
                    class={leaf ? "" : "inner"}
                  >
                    {leaf || chosen ? bone.name : ""}
                  </text>
                )}
                <title>{bone.name}</title>
              </g>
            );
          })}
        </svg>
      </div>
      {at !== undefined ? (
        <BoneForm key={itemAt(bones, at).name} clip={clip} bone={at} reload={reload} />
      ) : (
        <p class="dim structure-hint">
          {w("help.selectJoint")} <Recognised clip={clip} />
        </p>
      )}
    </div>
  );
}

/** A joint: filled with a sure name, in a ring with a guessed one, hollow without. */
function Dot({ bone, x, y, ink }: { bone: Bone; x: number; y: number; ink: string }) {
  const named = bone.mapped !== false;
  return (
    <>
      <circle cx={x} cy={y} r="4.5" fill={named ? ink : "var(--panel)"} stroke={ink} stroke-width={named ? 0 : 1.5} />
      {isGuess(bone) && (
        <circle cx={x} cy={y} r="7" fill="none" stroke="var(--warn)" stroke-width="1.5" stroke-dasharray="2 2" />
      )}
    </>
  );
}

/** How many joints have a name of MCML's, and how many of these are guesses. */
function Recognised({ clip }: { clip: Clip }) {
  const joints = clip.skeleton.view.bones.filter((bone) => bone.convention !== "shape");
  const guesses = joints.filter(isGuess).length;
  if (clip.skeleton.view.markers) return null;
  return (
    <>
      {r("label.jointsRecognised", { mapped: joints.filter((one) => one.mapped).length, total: joints.length })}
      {guesses > 0 && <span class="guess">{r("label.namesGuessed", { n: guesses })}</span>}
    </>
  );
}

function BoneForm({ clip, bone, reload }: { clip: Clip; bone: number; reload: () => void }) {
  const { view } = clip.shape.value;
  const joint = itemAt(view.bones, bone);
  const stored = vectorOf(clip.skeleton.view, bone);
  const vector = vectorOf(view, bone) ?? stored ?? [0, 0, 0];
  const length = Math.hypot(...vector);
  const above = joint.parent >= 0 ? itemAt(view.bones, joint.parent).name : "–";
  const editable = stored !== null && clip.pinned === null;
  const set = (next: number[]) => {
    if (next.every(Number.isFinite)) clip.setBone(bone, next as Vector);
  };
  return (
    <form class="bone-form" onSubmit={(event) => event.preventDefault()}>
      <h2 class="row">
        <span class="dot" style={{ background: `var(--${SIDE_TOKENS[numberAt(clip.skeleton.sides, bone)]})` }} />
        {joint.name}
        {joint.name !== joint.source_name && <span class="dim">{joint.source_name}</span>}
      </h2>
      {joint.convention !== "marker" && joint.convention !== "shape" && (
        <JointName clip={clip} bone={bone} reload={reload} />
      )}
      <div class="info-row">
        <span>{w("label.parent")}</span>
        <button
          type="button"
          class="button quiet dense"
          disabled={joint.parent < 0}
          onClick={() => clip.select([above])}
        >
          {above}
        </button>
      </div>
      <div class="info-row">
        <span>{w("label.channel")}</span>
        <span>
          {joint.channels.join(" ") || "–"} <span class="dim">{joint.rotation_order}</span>
        </span>
      </div>
      <div class="info-row">
        <span>{w("label.offsets")}</span>
        <span class="row">
          {["X", "Y", "Z"].map((axis, place) => (
            <label key={axis} class="row">
              <span class="dim">{axis}</span>
              <input
                class="field number"
                type="number"
                step="any"
                value={Number(numberAt(vector, place).toFixed(4))}
                disabled={!editable}
                onChange={(event) => {
                  const next = [...vector];
                  next[place] = Number(event.currentTarget.value);
                  set(next);
                }}
              />
            </label>
          ))}
        </span>
      </div>
      <div class="info-row">
        <span>{w("label.boneLength")}</span>
        <span class="row">
          <input
            class="field number"
            type="number"
            min="0"
            step="any"
            aria-label={w("label.boneLength")}
            value={Number(length.toFixed(4))}
            disabled={!editable || !length}
            onChange={(event) => {
              const wanted = Number(event.currentTarget.value);
              if (wanted > 0) set(vector.map((one) => (one / length) * wanted));
              else event.currentTarget.value = String(Number(length.toFixed(4)));
            }}
          />{" "}
          <span class="dim">{number(length * clip.skeleton.metres * 100, 1)} cm</span>
        </span>
      </div>
      {editable && <p class="dim">{w("help.handlesHelp")}</p>}
    </form>
  );
}
