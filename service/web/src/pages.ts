/**
 * The pages of the studio. A row of ../pages.json is a page: the router, the rail, keys, the palette, the bar and the
 * addresses that the server answers (`service/web/__init__.py`) follow from it.
 */
import type { ComponentType } from "preact";
import rows from "../pages.json";
import type { PageAddress } from "./state/session/route";
import type { IconName } from "./ui/icons";
import type { Word } from "./words";

export interface PageRow extends PageAddress {
  /** Its name in the bar and the rail. */
  title: Word;
  /** The command that opens it, and its key after G. */
  go?: Word;
  key?: string;
  icon?: IconName;
  /** Where in the rail it is; absent: not there. */
  rail?: "top" | "end";
  /** The page that the rail shows as open. */
  within?: string;
  /** Whether it shows the ends of the jobs that it started. */
  jobs?: boolean;
  /** The analyses that have their window here. */
  analyses?: string[];
  /** Its component, which has the name of the file, below panels/. */
  file: string;
}

type Component = ComponentType<{ id: string }>;
type Module = Partial<Record<string, Component>>;
const MODULES: Partial<Record<string, () => Promise<unknown>>> = import.meta.glob("./panels/*/*Page.tsx");

// A unit test checks that words, icons and files exist.
export const PAGES = rows as PageRow[];

/** The page that is the window of an analysis. */
export const windowOf = (analysis: string): PageRow | undefined =>
  PAGES.find((one) => one.analyses?.includes(analysis));

export const rowOf = (name: string): PageRow | undefined => PAGES.find((one) => one.name === name);

/** Load the code of a page. */
export async function load({ file }: PageRow): Promise<Component> {
  const name = file.split("/").at(-1) ?? "";
  const module = (await MODULES[`./panels/${file}.tsx`]?.()) as Module | undefined;
  const found = module?.[name];
  if (!found) throw new Error(`panels/${file}.tsx has no ${name}.`);
  return found;
}
