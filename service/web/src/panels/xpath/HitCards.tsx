/** The first frame ranges of an answer as small moving pictures; a click plays one. */
import { itemAt } from "../../lists";
import { MiddleCut } from "../../ui/MiddleCut";
import { ThumbnailView } from "../../ui/clips/ThumbnailView";
import { useThumbnail } from "../../ui/clips/useThumbnail";
import { number, w } from "../../words";
import type { Run } from "./answered";
import { cardsOf } from "./rangeTable";
import { x } from "./words";

export function HitCards({
  runs,
  picked,
  onPick,
}: {
  runs: readonly Run[];
  picked: number;
  onPick: (at: number) => void;
}) {
  return (
    <ul class="hit-cards" aria-label={x("label.hitCards")}>
      {cardsOf(runs).map((at) => (
        <HitCard key={at} run={itemAt(runs, at)} current={at === picked} onPick={() => onPick(at)} />
      ))}
    </ul>
  );
}

function HitCard({ run, current, onPick }: { run: Run; current: boolean; onPick: () => void }) {
  const { document, name, revision, first, last } = run;
  const picture = useThumbnail(document, { revision, first, last });
  return (
    <li>
      <button type="button" class="hit-card" aria-pressed={current} title={name} onClick={onPick}>
        <ThumbnailView thumbnail={picture} runs label="" />
        <strong>
          <MiddleCut text={name} />
        </strong>
        <span class="dim cut block">
          <span class="unseen">{w("label.framesWord")} </span>
          {number(first)}
          {last > first && `–${number(last)}`}
        </span>
      </button>
    </li>
  );
}
