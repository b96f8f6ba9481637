/** Filters and views under names: saved, opened by one press, shared by the address that they become. */
import { useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { collectionsChanged } from "../../state/library/collections";
import {
  asConditions,
  asFilter,
  asSavedView,
  asView,
  sameFilter,
  sameView,
  viewAddress,
  viewOf,
  type Filter,
  type View,
} from "../../state/library/filters";
import * as library from "../../state/library/library";
import { note, refuse } from "../../state/session/notes";
import { go, route } from "../../state/session/route";
import { AskName } from "../../ui/forms/AskName";
import { Icon } from "../../ui/icons";
import { useAsync } from "../../ui/useAsync";
import { useRoving } from "../../ui/useRoving";
import { w } from "../../words";

interface Saved {
  kind: "collections" | "queries";
  name: string;
  project: string;
  filter: Filter;
  /** null: of any order and form. */
  view: View | null;
  version: number;
  body: object;
}

export const useCollections = () =>
  useAsync((signal) => get("/collections", { query: { limit: 500 }, signal }), [], [collectionsChanged.value]);

export function SavedFilters({ collections }: { collections: readonly Schemas["Collection"][] }) {
  const [naming, setNaming] = useState(false);
  const queries = useAsync(
    (signal) => get("/queries", { query: { limit: 500 }, signal }),
    [],
    [collectionsChanged.value],
  );
  const now = library.filter.value;
  const saved: Saved[] = [
    ...collections.flatMap(({ where, view, name, project, version, description }) =>
      where
        ? [
            {
              kind: "collections" as const,
              name,
              project,
              version,
              filter: asFilter(where),
              view: asView(view),
              body: { where, view, description },
            },
          ]
        : [],
    ),
    ...(queries.value?.items ?? []).flatMap(({ q, variables, name, project, version, description }) =>
      Object.keys(variables ?? {}).length
        ? []
        : [
            {
              kind: "queries" as const,
              name,
              project,
              version,
              filter: { xpath: q },
              view: null,
              body: { q, description },
            },
          ],
    ),
  ];
  const filtered = Object.keys(now).length > 0;
  const view = viewOf(route.value.params);
  const isShown = (one: Saved) => sameFilter(one.filter, now) && (!one.view || sameView(one.view, view));
  const known = saved.some(isShown);
  const conditions = asConditions(now);
  const question = typeof now.xpath === "string" && Object.keys(now).length === 1 ? now.xpath : null;
  const keep = async (name: string) => {
    if (question !== null)
      await ask("put", "/queries/{name}", { path: { name }, body: { q: question, description: "" } });
    else
      await ask("put", "/collections/{name}", {
        path: { name },
        body: { where: conditions, view: asSavedView(view), description: "" },
      });
    collectionsChanged.value++;
    note(w("label.savedAs", { name }));
  };
  const roving = useRoving<HTMLElement>("button");
  if (!saved.length && !filtered) return null;
  return (
    <section class="facet" aria-label={w("label.savedFilters")} {...roving}>
      <h3>{w("label.savedFilters")}</h3>
      {saved.map((one) => {
        const chosen = isShown(one);
        return (
          <div key={`${one.kind} ${one.project} ${one.name}`} class="row saved-filter">
            <button
              type="button"
              class="facet-item"
              aria-pressed={chosen}
              title={[...Object.entries(one.filter), ...Object.entries(one.view ?? {})]
                .map(([name, value]) => `${name}: ${[value].flat().join(", ")}`)
                .join("\n")}
              onClick={() =>
                go(
                  viewAddress(chosen ? {} : one.filter, chosen ? null : one.view, route.peek().params, library.FILTERS),
                )
              }
            >
              <Icon name={one.kind === "queries" ? "xpath" : "search"} />
              <span class="cut">{one.name}</span>
            </button>
            <button
              type="button"
              class="button quiet icon dense"
              aria-label={w("button.removeFilter", { name: one.name })}
              onClick={() => void remove(one)}
            >
              <Icon name="close" />
            </button>
          </div>
        );
      })}
      {filtered &&
        !known &&
        (conditions || question !== null ? (
          <button type="button" class="facet-item dim" onClick={() => setNaming(true)}>
            <Icon name="plus" />
            {w("button.saveFilter")}
          </button>
        ) : (
          <p class="dim facet-note">{w("help.saveFilterNot")}</p>
        ))}
      {naming && (
        <AskName title={w("button.saveFilter")} onName={keep} onClose={() => setNaming(false)}>
          <p class="dim">{w("help.saveFilterHelp")}</p>
        </AskName>
      )}
    </section>
  );
}

async function remove({ kind, name, project, version, body }: Saved): Promise<void> {
  const path = kind === "queries" ? ("/queries/{name}" as const) : ("/collections/{name}" as const);
  try {
    await ask("delete", path, { path: { name }, query: { project }, match: version });
    collectionsChanged.value++;
    note(w("label.filterRemoved", { name }), {
      action: {
        text: w("button.undo"),
        run: () => {
          ask("put", path, { path: { name }, query: { project }, body: body as never }).then(
            () => collectionsChanged.value++,
            refuse,
          );
        },
      },
    });
  } catch (error) {
    refuse(error);
  }
}
