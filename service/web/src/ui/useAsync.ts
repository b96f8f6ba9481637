/** What a request answered, for components: the value, whether it still comes, what went wrong. */
import { useEffect, useState } from "preact/hooks";

export interface Loaded<T> {
  value: T | undefined;
  error: unknown;
  busy: boolean;
  again: () => void;
  /** What a write answered is the value from now on. */
  set: (value: T) => void;
}

/** Ask whenever `keys` change; the request before is aborted. The value of before stays until the next is there. */
export function useAsync<T>(ask: (signal: AbortSignal) => Promise<T>, keys: unknown[]): Loaded<T> {
  const [state, setState] = useState<{ value?: T; error?: unknown; busy: boolean }>({ busy: true });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const stop = new AbortController();
    setState((before) => ({ ...before, busy: true }));
    ask(stop.signal).then(
      (value) => setState({ value, busy: false }),
      (error) => {
        if (!stop.signal.aborted) setState((before) => ({ value: before.value, error, busy: false }));
      },
    );
    return () => stop.abort();
  }, [...keys, turn]);
  return { value: state.value, error: state.error, busy: state.busy, again: () => setTurn((before) => before + 1), set: (value) => setState({ value, busy: false }) };
}
