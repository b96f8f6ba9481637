/** The answer that the page shows: asks, stops what was asked before, adds pages. */
import { useRef, useState } from "preact/hooks";
import { remember } from "../../state/library/queries";
import { param, setParams } from "../../state/session/route";
import { extended, fetchAnswer, type Answered } from "./answered";

const formOf = (): Answered["as"] => (param("as") === "nodes" ? "json" : "runs");

/** The scope and the form that the address names; pages keep those of the first one. */
const scopeOf = (before: Answered | null) => ({
  project: param("project"),
  per: param("per") === "document",
  guesses: before?.guesses ?? param("guesses") !== "no",
  form: before?.as ?? formOf(),
  cursor: before?.cursor ?? null,
});

export interface Answering {
  answer: Answered | null;
  error: unknown;
  busy: boolean;
  /** Ask a query in the scope that the address names. */
  run: (query: string) => Promise<void>;
  /** The same while it is changed by hand: the answer before stays, as old, and the query is not kept in the history. */
  runLive: (query: string) => Promise<void>;
  /** Whether the answer is that to the query before. */
  isOld: boolean;
  /** The next page of the answer. */
  more: () => Promise<void>;
  stop: () => void;
}

export function useAnswer(): Answering {
  const [answer, setAnswer] = useState<Answered | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const [isOld, setOld] = useState(false);
  const stop = useRef<AbortController | null>(null);

  const ask = async (q: string, before: Answered | null, isLive = false): Promise<void> => {
    if (!q.trim()) return;
    stop.current?.abort();
    const { signal } = (stop.current = new AbortController());
    setBusy(true);
    setError(null);
    // Nothing is shown, copied or exported under a question that it does not answer.
    if (isLive) setOld(true);
    else if (!before) setAnswer(null);
    try {
      const found = await fetchAnswer({ q, ...scopeOf(before) }, signal);
      setAnswer(before ? extended(before, found) : found);
      setOld(false);
      if (before) return;
      if (!isLive) remember(q);
      setParams({ q });
    } catch (problem) {
      if ((problem as Error).name === "AbortError") return;
      setError(problem);
      setOld(false);
      setAnswer(null);
    } finally {
      if (stop.current.signal === signal) setBusy(false);
    }
  };
  return {
    answer,
    error,
    busy,
    isOld,
    run: (query) => ask(query, null),
    runLive: (query) => ask(query, null, true),
    more: async () => {
      if (answer?.cursor) await ask(answer.q, answer);
    },
    stop: () => stop.current?.abort(),
  };
}
