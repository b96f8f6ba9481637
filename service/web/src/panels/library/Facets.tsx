/** What the list can be narrowed by, with counts within the filter. A facet's own choice does not count against it. */
import { get, type Schemas } from "../../api/client";
import * as library from "../../state/library/library";
import { labelOf } from "../../state/session/formats";
import { param, route, setParams } from "../../state/session/route";
import { nameColour } from "../../motion/timeline/colours";
import { useRoving } from "../../ui/useRoving";
import { useAsync } from "../../ui/useAsync";
import { SavedFilters, useCollections } from "./SavedFilters";
import { FolderChoice } from "./Folders";
import { Histogram } from "./Histogram";
import { Trouble } from "../../ui/Trouble";
import { duration, number, w, type Word } from "../../words";

const SHOWN = 8;

interface Choice {
  value: string;
  text: string;
  count: number | null;
  colour?: string;
}

export function Facets() {
  const facets = useAsync(
    (signal) => get("/facets", { query: library.filter.value, signal }),
    [JSON.stringify(library.filter.value)],
    [library.version.value > 0, library.total.value],
  );
  const projects = useAsync((signal) => get("/projects", { signal }), [], [library.total.value]);
  const collections = useCollections().value?.items ?? [];
  // While a filter is counted the facets before stay, dimmed: what is typed or dragged in them goes on.
  const found = facets.value ?? facets.before;
  const filtered = Object.keys(library.filter.value).length > 0;
  if (!found) return <Trouble error={facets.error} retry={facets.again} />;
  const counts = (list: Schemas["Count"][]): Choice[] =>
    list.map((one) => ({ value: one.value, text: one.value, count: one.documents }));
  return (
    <div class={facets.value ? "" : "stale"} aria-busy={facets.busy}>
      {filtered && (
        <button
          type="button"
          class="button dense clear-filters"
          onClick={() => setParams(Object.fromEntries(library.FILTERS.map((name) => [name, null])), true)}
        >
          {w("button.clearFilters")}
        </button>
      )}
      <FolderChoice found={found} />
      <SavedFilters collections={collections} />
      <Group
        word="label.project"
        name="project"
        choices={withEmpty(counts(found.projects), projects.value?.items ?? [], filtered)}
      />
      <Collections collections={collections} />
      <Group
        word="label.motionName"
        name="motion_name"
        choices={counts(found.motion_names).map((one) => ({ ...one, colour: nameColour(one.value) }))}
      />
      <Group
        word="label.format"
        name="format"
        choices={counts(found.formats).map((one) => ({ ...one, text: labelOf(one.value) }))}
      />
      <Lengths found={found.lengths} />
      <Group
        word="label.frameRate"
        name="rate"
        choices={found.rates.map((one) => ({
          value: String(one.value),
          text: `${number(one.value)} Hz`,
          count: one.documents,
        }))}
      />
      <Group
        word="label.skeleton"
        name="skeleton"
        choices={found.skeletons.map((one) => ({
          value: String(one.skeleton),
          text: `${one.skeleton} · ${w("label.jointCount", { n: one.joints })}`,
          count: one.documents,
        }))}
      />
      {found.properties.map((one) => (
        <Property key={one.name} property={one} />
      ))}
    </div>
  );
}

/** Add the projects that are not counted, such as empty ones, while nothing is filtered: files can be imported into them. */
function withEmpty(choices: Choice[], projects: readonly string[], filtered: boolean): Choice[] {
  if (filtered) return choices;
  const known = new Set(choices.map((one) => one.value));
  return [
    ...choices,
    ...projects.filter((one) => !known.has(one)).map((one) => ({ value: one, text: one, count: null })),
  ];
}

function Group({ word, name, choices }: { word: Word; name: string; choices: Choice[] }) {
  const chosen = param(name);
  const roving = useRoving<HTMLElement>(".facet-item");
  const all =
    chosen && !choices.some((one) => one.value === chosen)
      ? [{ value: chosen, text: chosen, count: 0 }, ...choices]
      : choices;
  if (!all.length || (all.length === 1 && !chosen && !["project", "collection"].includes(name))) return null;
  const item = (one: Choice) => (
    <button
      key={one.value}
      type="button"
      class="facet-item"
      aria-pressed={chosen === one.value}
      onClick={() => setParams({ [name]: chosen === one.value ? null : one.value }, true)}
    >
      {one.colour && <span class="swatch" style={{ background: one.colour }} />}
      <span class="cut">{one.text}</span>
      {one.count !== null && <span class="count">{number(one.count)}</span>}
    </button>
  );
  return (
    <section class="facet" aria-label={w(word)} {...roving}>
      <h3>{w(word)}</h3>
      {all.slice(0, SHOWN).map(item)}
      {all.length > SHOWN && (
        <details>
          <summary class="facet-item dim">
            {w("label.more")} ({number(all.length - SHOWN)})
          </summary>
          {all.slice(SHOWN).map(item)}
        </details>
      )}
    </section>
  );
}

function Property({ property }: { property: Schemas["PropertyCounts"] }) {
  const conditions = route.value.params.getAll("property");
  const roving = useRoving<HTMLElement>(".facet-item");
  const own = conditions.find((one) => one.startsWith(`${property.name}:`));
  const choose = (value: string | null) => {
    const next = conditions.filter((one) => one !== own);
    const wanted = `${property.name}:${value}`;
    if (value !== null && wanted !== own) next.push(wanted);
    // One of several conditions: the address repeats the name.
    const params = new URLSearchParams(route.peek().params);
    params.delete("property");
    for (const one of next) params.append("property", one);
    history.pushState(null, "", `${location.pathname}?${params}`);
    route.value = { ...route.peek(), params };
  };
  return (
    <section class="facet" aria-label={property.name} {...roving}>
      <h3>{property.name}</h3>
      {property.numbers && (
        <Histogram
          histogram={property.numbers}
          chosen={own?.slice(property.name.length + 1) ?? ""}
          label={property.name}
          onChoose={choose}
          text={(value) => number(value, 1)}
        />
      )}
      {property.texts.slice(0, SHOWN).map((one) => (
        <button
          key={one.value}
          type="button"
          class="facet-item"
          aria-pressed={own === `${property.name}:${one.value}`}
          onClick={() => choose(one.value)}
        >
          <span class="cut">{one.value}</span>
          <span class="count">{number(one.documents)}</span>
        </button>
      ))}
    </section>
  );
}

/** Of all lengths under the other filters: what is chosen can be chosen wider. */
function Lengths({ found }: { found: Schemas["Histogram"] | null | undefined }) {
  const { length, ...others } = library.filter.value;
  const wide = useAsync(
    async (signal) => (length === undefined ? null : (await get("/facets", { query: others, signal })).lengths),
    [JSON.stringify(library.filter.value)],
    [library.total.value],
  );
  const histogram = length === undefined ? found : (wide.value ?? wide.before ?? found);
  if (!histogram) return null;
  return (
    <section class="facet" aria-label={w("label.length")}>
      <h3>{w("label.length")}</h3>
      <Histogram
        histogram={histogram}
        label={w("label.lengthInSeconds")}
        chosen={param("length")}
        onChoose={(value) => setParams({ length: value }, true)}
        text={duration}
      />
    </section>
  );
}

function Collections({ collections }: { collections: readonly Schemas["Collection"][] }) {
  const choices = collections
    .filter((one) => !one.where)
    .map((one) => ({
      value: one.project === "default" ? one.name : `${one.project}/${one.name}`,
      text: one.name,
      count: null,
    }));
  return <Group word="label.collections" name="collection" choices={choices} />;
}
