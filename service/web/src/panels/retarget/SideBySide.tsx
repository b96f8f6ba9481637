/** The motion and what becomes of it, played beside each other. A click on a joint selects its row of the mapping. */
import type { Signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Preview } from "../../motion/loading/preview";
import type { Motion } from "../../motion/loading/source";
import type { Player } from "../../state/clip/player";
import { Icon } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { Scrubber } from "../../ui/playing/Scrubber";
import { w } from "../../words";
import type { Pair } from "./MappingTable";

const APART = 1.3; // metres between the two bodies

function actorsOf(source: Motion, moved: Preview | null, player: Player): Actor[] {
  const own = {
    skeleton: source.skeleton,
    inPlace: true,
    shift: -APART / 2,
    positions: () => {
      source.blocks.arrived.value;
      return source.blocks.frame(player.frame.value);
    },
  };
  if (!moved) return [own];
  const made = {
    skeleton: moved.skeleton,
    inPlace: true,
    shift: APART / 2,
    positions: () => moved.frame(player.frame.value),
  };
  return [own, made];
}

/** The points of the selected joint of the source. */
const pointsOf = (source: Motion, selected: Signal<string | null>) => ({
  get value() {
    const point = selected.value === null ? undefined : source.skeleton.byName.get(selected.value);
    return point === undefined ? [] : [point];
  },
});

export function SideBySide({
  source,
  moved,
  name,
  player,
  pairs,
  selected,
  stale,
  busy,
}: {
  source: Motion;
  /** null until the first answer. */
  moved: Preview | null;
  /** Of the target. */
  name: string;
  player: Player;
  pairs: Pair[];
  /** A joint of the source. */
  selected: Signal<string | null>;
  stale: boolean;
  busy: boolean;
}) {
  const actors = useMemo(() => actorsOf(source, moved, player), [source, moved, player]);
  const marked = useMemo(() => pointsOf(source, selected), [source, selected]);
  const pick = (actor: number, point: number) => {
    if (actor === 0) selected.value = source.skeleton.view.bones[point]?.name ?? null;
    else {
      const target = moved?.skeleton.view.bones[point]?.name;
      selected.value = pairs.find((one) => one.target === target)?.source ?? null;
    }
  };
  return (
    <section class={`retarget-view ${stale ? "stale" : ""}`} aria-busy={busy}>
      {busy && <div class="busy" />}
      <MotionView actors={actors} selected={marked as never} label={`${source.name}, ${name}`} onPick={pick} />
      <div class="transport row">
        <button
          type="button"
          class="button quiet icon play"
          aria-label={w(player.playing.value ? "button.pause" : "button.play")}
          onClick={() => {
            player.loop.value = null;
            player.toggle();
          }}
        >
          <Icon name={player.playing.value ? "pause" : "play"} />
        </button>
        <Scrubber player={player} />
      </div>
    </section>
  );
}
