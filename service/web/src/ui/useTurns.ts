/** Writes of one component to one thing, in turn: two quick ones are no conflict. */
import { useRef } from "preact/hooks";

/** Each write waits for the one before and gets what that one left; undefined: there was none, or it failed. */
export function useTurns<T>(): (write: (left: T | undefined) => Promise<T>) => Promise<T> {
  const last = useRef<Promise<T | undefined>>(Promise.resolve(undefined));
  return (write) => {
    const done = last.current.then(write);
    last.current = done.catch(() => undefined);
    return done;
  };
}
