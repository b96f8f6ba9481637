/** Pages that are loaded when they are opened first. */
import type { ComponentType } from "preact";
import { useEffect, useState } from "preact/hooks";
import { Trouble } from "./Trouble";

export function lazy<P extends object>(load: () => Promise<ComponentType<P>>): ComponentType<P> {
  let ready: ComponentType<P> | null = null;
  return function Lazy(props: P) {
    const [, setTurn] = useState(0);
    const [error, setError] = useState<unknown>(null);
    useEffect(() => {
      if (ready) return;
      load().then((found) => {
        ready = found;
        setTurn((turn) => turn + 1);
      }, setError);
    }, []);
    if (error) return <Trouble error={error} retry={() => location.reload()} />;
    const Ready = ready;
    return Ready ? <Ready {...props} /> : <div class="busy" role="presentation" />;
  };
}
