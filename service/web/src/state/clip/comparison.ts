/** Clips that are shown beside the open one: which, how they are placed and timed. The address says so. */
import { signal } from "@preact/signals";
import { get } from "../../api/client";
import { motionOf, type Motion } from "../../motion/loading/source";
import type { Sync, Timed } from "../../motion/comparison/sync";
import { refuse } from "../session/notes";
import { param, setParams } from "../session/route";

export const MOST_BESIDE = 3;
/** Colours of the clips, the open one first. */
export const BESIDE_COLOURS = ["name0", "name1", "name2", "name3"] as const;

export interface Beside extends Motion, Timed {
  up: string | null | undefined;
}

/** Those that are loaded, in the address's order. */
export const beside = signal<readonly Beside[]>([]);

export const besideIds = (): string[] => [...new Set(param("cmp").split(",").filter(Boolean))].slice(0, MOST_BESIDE);
export const besideSync = (): Sync =>
  ["frame", "span"].includes(param("cmpsync")) ? (param("cmpsync") as Sync) : "time";
/** Laid over one another; else side by side. */
export const laidOver = (): boolean => param("cmpas") === "over";

export function putBeside(ids: string[]): void {
  setParams(
    ids.length ? { cmp: ids.slice(0, MOST_BESIDE).join(",") } : { cmp: null, cmpsync: null, cmpas: null },
    true,
  );
}

/** Load what the address names; `still` says whether it is still wanted. */
export async function loadBeside(still: () => boolean): Promise<void> {
  const wanted = besideIds();
  const found = await Promise.all(
    wanted.map(async (id) => {
      const known = beside.peek().find((one) => one.id === id);
      if (known) return known;
      try {
        const [motion, detail] = await Promise.all([motionOf(id), get("/documents/{id}", { path: { id } })]);
        return { ...motion, labels: detail.labels, up: detail.up };
      } catch (error) {
        if (still()) refuse(error);
        return null;
      }
    }),
  );
  if (still()) beside.value = found.filter((one) => one !== null);
}
