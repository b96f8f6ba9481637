/** The candidates of a level as a list of faces. */
import { numberAt } from "../../lists";
import { useEffect } from "preact/hooks";
import { FaceThumb } from "./FaceThumb";
import { type Level, type Space } from "./space";
import { f } from "./words";

const SHOWN = 120;

/** The candidates as faces: the same as on the map, for keys and for those who do not see it. */
export function Candidates({
  space,
  level,
  keys,
  onHover,
  onPick,
}: {
  space: Space;
  level: Level;
  keys: number[];
  onHover: (frame: number) => void;
  onPick: (candidate: number) => void;
}) {
  const from = keys.length ? level.candidates.indexOf(keys.at(-1)!) : -1;
  const near = new Map((level.neighbours[from] ?? []).map((one) => [one.to, one.length]));
  const all = Array.from(level.candidates.subarray(0, SHOWN), (_, at) => at);
  const shown =
    from < 0
      ? all
      : [...[...near.keys()].slice(0, SHOWN / 2), ...all.filter((one) => !near.has(one) && one !== from)].slice(
          0,
          SHOWN,
        );
  useEffect(() => space.want(shown.map((one) => numberAt(level.candidates, one))), [level, from]);
  return (
    <ul class="faces-candidates" aria-label={f("label.candidates", { n: level.candidates.length })}>
      {shown.map((one) => {
        const { take, frame } = space.wordsOf(numberAt(level.candidates, one));
        return (
          <li key={one}>
            <button
              type="button"
              class={near.has(one) ? "near" : ""}
              title={f("label.shown", { take, frame })}
              onPointerEnter={() => onHover(numberAt(level.candidates, one))}
              onPointerLeave={() => onHover(-1)}
              onFocus={() => onHover(numberAt(level.candidates, one))}
              onBlur={() => onHover(-1)}
              onClick={() => onPick(one)}
            >
              <FaceThumb space={space} frame={numberAt(level.candidates, one)} />
              <span class="unseen">{f("label.shown", { take, frame })}</span>
              <span>
                {near.has(one) ? f("label.linkedTo", { n: Math.round(near.get(one)!) }) : from < 0 ? "" : "–"}
              </span>
            </button>
          </li>
        );
      })}
    </ul>
  );
}
