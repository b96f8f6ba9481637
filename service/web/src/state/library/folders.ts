/** The library as folders: values of one facet, each with the number of its clips under the other filters. */
import type { Schemas } from "../../api/client";
import { addressOf } from "./filters";
import { FILTERS, filter as filterNow } from "./library";

type FacetList = Schemas["FacetList"];

/** A facet by which clips are grouped: a filter with one value, or `property:NAME`. */
export const GROUPINGS = ["project", "motion_name", "format", "skeleton", "rate"] as const;
export type Grouping = (typeof GROUPINGS)[number] | `property:${string}`;

export interface Folder {
  value: string;
  documents: number;
  /** Of a skeleton. */
  joints?: number;
}

/** Most folders of one page; the service counts no more values of a facet. */
export const MOST_FOLDERS = 1000;

/** The facets that have values: those of all clips, and properties that are texts. */
export function groupingsOf(found: FacetList): Grouping[] {
  const named = found.properties.filter((one) => one.texts.length > 0).map((one): Grouping => `property:${one.name}`);
  return [...GROUPINGS.filter((one) => foldersOf(found, one).length > 0), ...named];
}

/** The grouping that an address names; null where it names none. */
export function readGrouping(text: string): Grouping | null {
  const known = GROUPINGS.find((one) => one === text);
  return known ?? (/^property:./.test(text) ? (text as Grouping) : null);
}

export function foldersOf(found: FacetList, grouping: Grouping): Folder[] {
  switch (grouping) {
    case "project":
      return found.projects;
    case "motion_name":
      return found.motion_names;
    case "format":
      return found.formats;
    case "rate":
      return found.rates.map(({ value, documents }) => ({ value: String(value), documents }));
    case "skeleton":
      return found.skeletons.map(({ skeleton, joints, documents }) => ({ value: String(skeleton), joints, documents }));
    default:
      return found.properties.find((one) => `property:${one.name}` === grouping)?.texts ?? [];
  }
}

type Filter = typeof filterNow.value;

const folderConditions = (filter: Filter): string[] => [filter.property ?? []].flat();

/** The value of the folder that a filter opens; null where none is open. */
export function openFolder(filter: Filter, grouping: Grouping): string | null {
  if (!grouping.startsWith("property:")) return [filter[grouping] ?? []].flat()[0] ?? null;
  const beginning = `${grouping.slice("property:".length)}:`;
  const own = folderConditions(filter).find((one) => one.startsWith(beginning));
  return own === undefined ? null : own.slice(beginning.length);
}

/** The address of a folder; value: null for all folders. */
export function folderAddress(
  filter: Filter,
  params: URLSearchParams,
  grouping: Grouping,
  value: string | null,
): string {
  const next: Record<string, string | string[]> = Object.fromEntries(
    Object.entries(filter).filter(([name]) => name !== grouping),
  );
  if (grouping.startsWith("property:")) {
    const name = grouping.slice("property:".length);
    const others = folderConditions(filter).filter((one) => !one.startsWith(`${name}:`));
    next.property = value === null ? others : [...others, `${name}:${value}`];
  } else if (value !== null) next[grouping] = value;
  return addressOf(next, params, FILTERS);
}
