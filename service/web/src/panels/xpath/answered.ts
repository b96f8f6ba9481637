/** An answer of the server with what was asked, page after page. */
import { get, type Schemas } from "../../api/client";
import type { Item } from "./Answer";

export type Run = Schemas["RunItem"];

/** q, project, per, guesses: what was asked. single: the answer is one value. rangeOf: what each range has the figures of. */
export interface Answered {
  q: string;
  project: string;
  as: "runs" | "json";
  type: string;
  single: boolean;
  per: boolean;
  guesses: boolean;
  rangeOf: string | null;
  items: (Run | Item)[];
  totals: Schemas["RunTotals"] | null;
  total: number | null;
  cursor: string | null;
  ms: number;
  explain: unknown;
  complete: boolean;
  warnings: string[];
}

export interface Question {
  q: string;
  project: string;
  per: boolean;
  /** Whether clips with a guessed unit, up axis or floor count. */
  guesses: boolean;
  form: Answered["as"];
  /** Of the page before; null: the first page. */
  cursor: string | null;
}

export async function fetchAnswer(asked: Question, signal: AbortSignal): Promise<Answered> {
  const { q, project, per, guesses, form, cursor } = asked;
  const began = performance.now();
  const found = (await get("/xpath", {
    query: {
      q,
      as: form,
      project: project || undefined,
      per: per ? "document" : undefined,
      limit: 500,
      cursor: cursor ?? undefined,
      explain: true,
      otherwise: form === "runs" ? "json" : undefined,
      with: form !== "runs" ? undefined : cursor ? "range" : "totals,range",
      guesses: guesses ? undefined : "no",
    },
    signal,
  })) as Schemas["QueryAnswer"];
  return {
    q,
    project,
    as: found.type === "runs" ? "runs" : "json",
    type: found.type,
    single: !found.items,
    per,
    guesses,
    rangeOf: found.range_of ?? null,
    items: (found.items ?? [{ value: found.value }]) as Answered["items"],
    totals: found.totals ?? null,
    total: found.total ?? null,
    cursor: found.next_cursor ?? null,
    ms: Math.round(performance.now() - began),
    explain: found.explain,
    complete: found.complete,
    warnings: found.warnings ?? [],
  };
}

/** An answer with its next page. */
export const extended = (before: Answered, next: Answered): Answered => ({
  ...next,
  items: [...before.items, ...next.items],
  totals: next.totals ?? before.totals,
  total: next.total ?? before.total,
});
