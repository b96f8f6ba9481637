/** A hit of a search as a small moving picture; a click plays its frames. */
import { MiddleCut } from "../../../ui/MiddleCut";
import { ThumbnailView } from "../../../ui/clips/ThumbnailView";
import { useThumbnail } from "../../../ui/clips/useThumbnail";
import { number, w } from "../../../words";
import type { Hit } from "./asked";

const DIGITS = 3;

export function HitCard({
  hit,
  href,
  current,
  onOpen,
}: {
  hit: Hit;
  href: string;
  current: boolean;
  onOpen: (event: MouseEvent) => void;
}) {
  const picture = useThumbnail(hit.document, hit);
  const frames = number(hit.first) + (hit.last > hit.first ? `–${number(hit.last)}` : "");
  return (
    <li>
      <a class="hit" href={href} aria-current={current ? "true" : undefined} title={hit.name} onClick={onOpen}>
        <ThumbnailView thumbnail={picture} runs label="" />
        <strong>
          <MiddleCut text={hit.name} />
        </strong>
        <span class="block">
          <span class="dim cut block">
            <span class="unseen">{w("label.framesWord")} </span>
            {frames}
          </span>
          <span class="n" title={w("help.distanceHelp")}>
            <span class="unseen">{w("label.distance")} </span>
            {hit.distance.toFixed(DIGITS)}
          </span>
        </span>
      </a>
    </li>
  );
}
