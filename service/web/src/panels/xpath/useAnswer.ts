/** The answer that the page shows: asks, stops what was asked before, adds pages. */
import { useRef, useState } from "preact/hooks";
import { remember } from "../../state/library/queries";
import { param, setParams } from "../../state/session/route";
import { extended, fetchAnswer, type Answered } from "./answered";

const formOf = (): Answered["as"] => (param("as") === "nodes" ? "json" : "runs");

export interface Answering {
  answer: Answered | null;
  error: unknown;
  busy: boolean;
  /** Ask a query in the scope that the address names. */
  run: (query: string) => Promise<void>;
  /** The next page of the answer. */
  more: () => Promise<void>;
  stop: () => void;
}

export function useAnswer(): Answering {
  const [answer, setAnswer] = useState<Answered | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const stop = useRef<AbortController | null>(null);

  const ask = async (q: string, before: Answered | null): Promise<void> => {
    if (!q.trim()) return;
    stop.current?.abort();
    const { signal } = (stop.current = new AbortController());
    const scope = { project: param("project"), per: param("per") === "document" };
    setBusy(true);
    setError(null);
    // Nothing is shown, copied or exported under a question that it does not answer.
    if (!before) setAnswer(null);
    try {
      const found = await fetchAnswer(
        { q, ...scope, form: before?.as ?? formOf(), cursor: before?.cursor ?? null },
        signal,
      );
      setAnswer(before ? extended(before, found) : found);
      if (before) return;
      remember(q);
      setParams({ q });
    } catch (problem) {
      if ((problem as Error).name === "AbortError") return;
      setError(problem);
      setAnswer(null);
    } finally {
      if (stop.current.signal === signal) setBusy(false);
    }
  };
  return {
    answer,
    error,
    busy,
    run: (query) => ask(query, null),
    more: async () => {
      if (answer?.cursor) await ask(answer.q, answer);
    },
    stop: () => stop.current?.abort(),
  };
}
