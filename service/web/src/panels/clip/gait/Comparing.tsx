/** Chooses the trials that a clip is compared with, and saves the report. */
import { address, get, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { collectionsChanged } from "../../../state/library/collections";
import { useAsync } from "../../../ui/useAsync";
import { w, type Word } from "../../../words";

/** Names of collections, as requests write them; "" for none. */
export interface Others {
  compare: string;
  reference: string;
}
export type Compared = Schemas["GaitComparison"];

const CHOICES: [keyof Others, Word][] = [
  ["reference", "label.normalBand"],
  ["compare", "label.compareWith"],
];

/** The other trials, measured with the same quantities; null while none are chosen. */
export const useCompared = (clip: Clip, others: Others, quantity: readonly string[]) =>
  useAsync(
    (signal) =>
      others.compare || others.reference
        ? get("/gait", { query: { ...queryOf(clip, others), quantity: [...quantity] }, signal })
        : Promise.resolve(null),
    [clip, others, quantity.join()],
  );

const queryOf = (clip: Clip, { compare, reference }: Others) => ({
  document: [clip.id],
  ...(compare ? { compare: [compare] } : {}),
  ...(reference ? { reference: [reference] } : {}),
});

export function Comparing({ clip, others, choose }: { clip: Clip; others: Others; choose: (next: Others) => void }) {
  const collections = useAsync(
    (signal) => get("/collections", { query: { limit: 500 }, signal }),
    [],
    [collectionsChanged.value],
  );
  const names = (collections.value?.items ?? []).map(({ project, name }) => `collection:${project}/${name}`);
  return (
    <div class="row wrap gait-others">
      {CHOICES.map(([kind, word]) => (
        <label key={kind} class="row" title={w("help.collectionsHelp")}>
          {w(word)}
          <select
            class="field"
            value={others[kind]}
            onChange={(event) => choose({ ...others, [kind]: event.currentTarget.value })}
          >
            <option value="">{w("label.none")}</option>
            {names.map((name) => (
              <option key={name} value={name}>
                {name.slice("collection:".length)}
              </option>
            ))}
          </select>
        </label>
      ))}
      <span class="tail" />
      {(["pdf", "csv"] as const).map((format) => (
        <a
          key={format}
          class="button dense"
          href={address("/gait/report", {}, { ...queryOf(clip, others), format })}
          download=""
        >
          {w(format === "pdf" ? "button.saveReport" : "button.saveCycles")}
        </a>
      ))}
    </div>
  );
}
