/** The key faces of a path that is being made, and the way around where two of them are not linked. */
import { number } from "../../words";
import { FaceThumb } from "./FaceThumb";
import type { Space } from "./space";
import { f } from "./words";

/** The way around between faces that are not linked: frames, and its length in millimetres. */
export type Route = { way: number[]; length: number } | "none";

interface Props {
  space: Space;
  keys: number[];
  route: Route | null;
  busy: boolean;
  onKeys: (next: number[]) => void;
  onRoute: () => void;
  onMake: () => void;
}

export function KeyFaces({ space, keys, route, busy, onKeys, onRoute, onMake }: Props) {
  return (
    <section class="faces-path" aria-label={f("label.path")}>
      <h3>{f("label.path")}</h3>
      {!keys.length && <p class="dim">{f("help.pathHelp")}</p>}
      <ol class="faces-keys">
        {keys.map((key, at) => (
          <li key={`${key}-${at}`}>
            <button
              type="button"
              title={f("button.removeKey", { n: at + 1 })}
              aria-label={f("button.removeKey", { n: at + 1 })}
              onClick={() => onKeys(keys.slice(0, at))}
            >
              <FaceThumb space={space} frame={key} />
              <span>{at + 1}</span>
            </button>
          </li>
        ))}
      </ol>
      {route && (
        <div class="banner warn" role="alert">
          <div class="grow">
            <strong>{f("help.notLinked")}</strong>
            <p>
              {route === "none"
                ? f("help.noRoute")
                : f("help.route", { n: route.way.length - 2, mm: number(route.length, 0) })}
            </p>
          </div>
          {route !== "none" && (
            <button type="button" class="button" onClick={onRoute}>
              {f("button.takeRoute")}
            </button>
          )}
        </div>
      )}
      <div class="row">
        <button type="button" class="button primary" disabled={keys.length < 2 || busy} onClick={onMake}>
          {busy ? f("label.walking") : f("button.walk")}
        </button>
      </div>
    </section>
  );
}
