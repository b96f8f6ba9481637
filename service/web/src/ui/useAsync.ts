/** What a request answered, for components: the value, whether it still comes, what went wrong. */
import { useEffect, useState } from "preact/hooks";
import { Offline } from "../api/client";

export interface Loaded<T> {
  /** The answer to the question that is asked now. */
  value: T | undefined;
  /** The answer to the last question before, while the one of now has none; undefined once it has failed. To be shown as old. */
  before: T | undefined;
  error: unknown;
  busy: boolean;
  again: () => void;
  /** What a write answered is the value from now on. */
  set: (value: T) => void;
}

interface State<T> {
  keys: readonly unknown[];
  value?: T;
  before?: T;
  error?: unknown;
  busy: boolean;
}

const isSame = (one: readonly unknown[], other: readonly unknown[]): boolean =>
  one.length === other.length && one.every((key, at) => Object.is(key, other[at]));

/** The state of a question: another one has no value yet, and no error. */
export const stateOf = <T>(was: State<T>, keys: readonly unknown[]): State<T> =>
  isSame(was.keys, keys)
    ? was
    : { keys, busy: true, before: was.error === undefined ? (was.value ?? was.before) : undefined };

/** What a failure leaves: nothing, unless it is only that no answer came to a question that was answered before. */
export const failed = <T>(was: State<T>, keys: readonly unknown[], error: unknown): State<T> => ({
  keys,
  error,
  busy: false,
  value: error instanceof Offline && isSame(was.keys, keys) ? was.value : undefined,
});

/** Ask whenever `keys`, which say the question, or `fresh` change; the request before is aborted. The value stays while the same question
 * is asked again; of another question it is gone at once. fresh: after what the same question may have another answer. */
export function useAsync<T>(
  ask: (signal: AbortSignal) => Promise<T>,
  keys: readonly unknown[],
  fresh: readonly unknown[] = [],
): Loaded<T> {
  const [state, setState] = useState<State<T>>({ keys, busy: true });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const stop = new AbortController();
    setState((was) => ({ ...stateOf(was, keys), busy: true }));
    ask(stop.signal).then(
      (value) => {
        if (!stop.signal.aborted) setState({ keys, value, busy: false });
      },
      (error) => {
        if (!stop.signal.aborted) setState((was) => failed(was, keys, error));
      },
    );
    return () => stop.abort();
  }, [...keys, ...fresh, turn]);
  // In the same rendering: no question is ever shown with the answer to another.
  const { value, before, error, busy } = stateOf(state, keys);
  return {
    value,
    before,
    error,
    busy,
    again: () => setTurn((was) => was + 1),
    set: (next) => setState({ keys, value: next, busy: false }),
  };
}
