/** Somebody saved meanwhile: what both changed, and the ways out. */
import type { ApiError, Schemas } from "../../api/client";
import type { Clip } from "../../state/clip/clip";
import { without } from "../../state/editing/draft";
import { Icon } from "../../ui/icons";
import { w } from "../../words";
import { saveClip } from "./keys";

type Conflict = Schemas["Conflict"];
const SHOWN = 6;

export function ConflictBanner({ clip, reload }: { clip: Clip; reload: () => void }) {
  const { problem } = clip.trouble.value as ApiError;
  const conflicts = (problem.details as { conflicts?: Conflict[] } | null | undefined)?.conflicts ?? [];
  const one = (value: unknown) =>
    Array.isArray(value)
      ? value.map(String).slice(0, 3).join(", ") + (value.length > 3 ? " …" : "")
      : String(value ?? "–");
  return (
    <div class="banner warn" role="alert">
      <Icon name="warn" />
      <div class="grow">
        <strong>{w("error.conflict")}</strong>
        {conflicts.length > 0 && <p>{w("help.conflictBoth", { n: conflicts.length })}</p>}
        {conflicts.length ? (
          <table>
            <thead>
              <tr>
                <th>{w("label.bothChanged")}</th>
                <th>{w("label.theirs")}</th>
                <th>{w("label.mine")}</th>
              </tr>
            </thead>
            <tbody>
              {conflicts.slice(0, SHOWN).map((item, index) => (
                <tr key={index}>
                  <td>
                    {item.address}
                    {item.first ? ` ${w("label.framesOf", { first: item.first, last: item.last ?? item.first })}` : ""}
                  </td>
                  <td>{one(item.theirs)}</td>
                  <td>{one(item.mine)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        ) : (
          <p>{w("help.conflictHelp")}</p>
        )}
      </div>
      {conflicts.length > 0 && (
        <button type="button" class="button" onClick={() => void clip.insist().then((done) => done && reload())}>
          {w("button.keepMine")}
        </button>
      )}
      {conflicts.length > 0 && (
        <button
          type="button"
          class="button"
          onClick={() => {
            clip.change(without(clip.draft.peek(), conflicts));
            void saveClip(clip, reload, true);
          }}
        >
          {w("button.takeTheirs")}
        </button>
      )}
      {!conflicts.length && (
        <button type="button" class="button" onClick={() => void saveClip(clip, reload, true)}>
          {w("button.merge")}
        </button>
      )}
      <button
        type="button"
        class="button quiet"
        onClick={() => {
          clip.discard();
          reload();
        }}
      >
        {w("button.discard")}
      </button>
    </div>
  );
}
