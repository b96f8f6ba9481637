/** Other clips beside the open one: chosen, named with what their passports say, timed, taken away. */
import { itemAt } from "../../../lists";
import { useEffect, useState } from "preact/hooks";
import type { Sync } from "../../../motion/comparison/sync";
import type { SkeletonView } from "../../../motion/body/skeleton";
import type { Clip } from "../../../state/clip/clip";
import {
  BESIDE_COLOURS,
  MOST_BESIDE,
  beside,
  besideIds,
  besideSync,
  laidOver,
  loadBeside,
  putBeside,
} from "../../../state/clip/comparison";
import { param, setParams } from "../../../state/session/route";
import { Chooser } from "../../../ui/clips/ClipChooser";
import { Icon } from "../../../ui/icons";
import { rate, w } from "../../../words";

export function CompareButton({ clip }: { clip: Clip }) {
  const [open, setOpen] = useState(false);
  const ids = besideIds();
  const choose = (id: string) => putBeside(ids.includes(id) ? ids.filter((one) => one !== id) : [...ids, id]);
  return (
    <>
      <button type="button" class="button" aria-pressed={ids.length > 0} onClick={() => setOpen(true)}>
        {w("button.compare")}
      </button>
      {open && (
        <Chooser
          title={w("button.compare")}
          help={w("help.compareHelp", { n: MOST_BESIDE })}
          chosen={ids}
          most={MOST_BESIDE}
          without={clip.id}
          onClose={() => setOpen(false)}
          onChoose={choose}
        />
      )}
    </>
  );
}

/** Follows the address; stands over the viewer while something is compared. */
export function Compared({ clip }: { clip: Clip }) {
  const named = param("cmp");
  useEffect(() => {
    let alive = true;
    void loadBeside(() => alive);
    return () => {
      alive = false;
    };
  }, [named, clip]);
  useEffect(
    () => () => {
      beside.value = [];
    },
    [],
  );
  const others = beside.value;
  if (!others.length) return null;
  const sync = besideSync();
  const guessed = [clip.skeleton, ...others.map((one) => one.skeleton)].some((one) => !one.view.unit);
  return (
    <section class="compared" aria-label={w("button.compare")}>
      <ul>
        <Line ink={BESIDE_COLOURS[0]} name={clip.detail.name} view={clip.skeleton.view} />
        {others.map((one, place) => (
          <Line
            key={one.id}
            ink={itemAt(BESIDE_COLOURS, place + 1)}
            name={one.name}
            view={one.skeleton.view}
            onRemove={() => putBeside(besideIds().filter((id) => id !== one.id))}
          />
        ))}
      </ul>
      <span class="grow" />
      {guessed && <span class="dim">{w("help.sizesGuessed")}</span>}
      <span class="row wrap">
        <span class="segments" role="group" aria-label={w("label.placed")}>
          <button type="button" aria-pressed={!laidOver()} onClick={() => setParams({ cmpas: null })}>
            {w("label.sideBySide")}
          </button>
          <button type="button" aria-pressed={laidOver()} onClick={() => setParams({ cmpas: "over" })}>
            {w("label.laidOver")}
          </button>
        </span>
        <span class="segments" role="group" aria-label={w("label.inStep")}>
          {(
            [
              ["time", "byTime"],
              ["frame", "byFrame"],
              ["span", "bySpan"],
            ] as [Sync, "byTime" | "byFrame" | "bySpan"][]
          ).map(([one, word]) => (
            <button
              key={one}
              type="button"
              aria-pressed={sync === one}
              onClick={() => setParams({ cmpsync: one === "time" ? null : one })}
            >
              {w(`label.${word}`)}
            </button>
          ))}
        </span>
      </span>
    </section>
  );
}

function Line({ ink, name, view, onRemove }: { ink: string; name: string; view: SkeletonView; onRemove?: () => void }) {
  return (
    <li class="row">
      <span class="swatch" style={{ background: `var(--${ink})` }} />
      <strong class="cut">{name}</strong>
      <span class={view.unit ? "dim" : "dim guess"} title={w("label.unit")}>
        {view.likely_unit ?? w("label.unitUnknown")}
      </span>
      <span class={view.seconds_per_frame ? "dim" : "dim guess"} title={w("label.rateWord")}>
        {rate(view.seconds_per_frame)}
      </span>
      <span class={view.up ? "dim" : "dim guess"} title={w("label.up")}>
        {view.likely_up}
      </span>
      {onRemove && (
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.notCompared", { name })}
          title={w("button.notCompared", { name })}
          onClick={onRemove}
        >
          <Icon name="close" />
        </button>
      )}
    </li>
  );
}
