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

/** The library under a filter; `others` of the address stay, such as its view. */
export function addressOf(filter: Filter, others: URLSearchParams, filters: readonly string[]): string {
  const params = new URLSearchParams([...others].filter(([name]) => !filters.includes(name)));
  for (const [name, value] of Object.entries(filter))
    for (const one of typeof value === "string" ? [value] : value) params.append(name, one);
  const text = params.toString();
  return `/library${text ? `?${text}` : ""}`;
}
