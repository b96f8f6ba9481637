/** Filters of the library that are kept: as conditions of a collection, or as a question where they are one. */
import type { Schemas } from "../../api/client";

export type Filter = Readonly<Record<string, string | readonly string[]>>;
type Conditions = Schemas["Conditions"];

/** What a collection holds by; null where it cannot: an XPath, a collection. */
export function asConditions(filter: Filter): Conditions | null {
  if (filter.xpath !== undefined || filter.collection !== undefined || !Object.keys(filter).length) return null;
  const { skeleton, property, ...texts } = filter;
  return {
    ...texts,
    ...(skeleton === undefined ? {} : { skeleton: Number(skeleton) }),
    ...(property === undefined ? {} : { property: [...property] }),
  };
}

export function asFilter(where: Conditions): Filter {
  const said = Object.entries(where).filter(
    ([, value]) => value !== null && value !== undefined && value !== "" && !(Array.isArray(value) && !value.length),
  );
  return Object.fromEntries(said.map(([name, value]) => [name, Array.isArray(value) ? value : String(value)]));
}

const parts = (filter: Filter): string[] =>
  Object.entries(filter)
    .flatMap(([name, value]) => (typeof value === "string" ? [value] : value).map((one) => `${name}=${one}`))
    .sort();

export const sameFilter = (one: Filter, other: Filter): boolean => parts(one).join("\n") === parts(other).join("\n");

/** How the library is shown: parameters of its address. */
export const VIEW = ["sort", "view", "folders"] as const;

export const viewOf = (params: URLSearchParams): View =>
  Object.fromEntries(VIEW.flatMap((name) => (params.get(name) ? [[name, params.get(name)]] : [])));

export type View = Readonly<Partial<Record<(typeof VIEW)[number], string>>>;

/** The view of a collection, as the address names it; null where it was saved without one. */
export function asView(saved: Schemas["LibraryView"] | null | undefined): View | null {
  if (!saved) return null;
  const { sort, layout, folders } = saved;
  return { ...(sort && { sort }), ...(layout === "list" && { view: "list" }), ...(folders && { folders }) };
}

export const asSavedView = ({ sort, view, folders }: View): Schemas["LibraryView"] => ({
  sort: sort ?? "newest",
  layout: view === "list" ? "list" : "grid",
  ...(folders && { folders }),
});

/** The same order, form and folders; the newest first where nothing is said. */
export const sameView = (one: View, other: View): boolean =>
  VIEW.every(
    (name) => (one[name] ?? "") === (other[name] ?? "") || (name === "sort" && isNewest(one) && isNewest(other)),
  );

const isNewest = ({ sort }: View): boolean => sort === undefined || sort === "newest";

/** The library under a filter, in a view; null: in the one that is shown. */
export function viewAddress(
  filter: Filter,
  view: View | null,
  params: URLSearchParams,
  filters: readonly string[],
): string {
  if (!view) return addressOf(filter, params, filters);
  const others = new URLSearchParams([...params].filter(([name]) => !(VIEW as readonly string[]).includes(name)));
  for (const name of VIEW) {
    const value = view[name];
    if (value && value !== "newest") others.set(name, value);
  }
  return addressOf(filter, others, filters);
}

/** The library under a filter; `others` of the address stay, such as its view. */
export function addressOf(filter: Filter, others: URLSearchParams, filters: readonly string[]): string {
  const params = new URLSearchParams([...others].filter(([name]) => !filters.includes(name)));
  for (const [name, value] of Object.entries(filter))
    for (const one of typeof value === "string" ? [value] : value) params.append(name, one);
  const text = params.toString();
  return `/library${text ? `?${text}` : ""}`;
}
