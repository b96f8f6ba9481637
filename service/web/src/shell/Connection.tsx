/** A strip while the server does not answer; it asks again by itself. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { w } from "../words";

const lost = signal<Date | null>(null);
const ASK_SECONDS = 15;
const ASK_SECONDS_LOST = 5;

async function ask(): Promise<void> {
  try {
    const answer = await fetch("/healthz", { cache: "no-store" });
    lost.value = answer.ok ? null : (lost.value ?? new Date());
  } catch {
    lost.value ??= new Date();
  }
}

export function Connection() {
  useEffect(() => {
    let timer = 0;
    const next = () => {
      timer = window.setTimeout(
        async () => {
          if (!document.hidden) await ask();
          next();
        },
        (lost.value ? ASK_SECONDS_LOST : ASK_SECONDS) * 1000,
      );
    };
    const offline = () => void ask();
    addEventListener("offline", offline);
    next();
    return () => {
      window.clearTimeout(timer);
      removeEventListener("offline", offline);
    };
  }, []);
  if (!lost.value) return null;
  return (
    <div class="banner warn" role="status">
      {w("error.offline", { time: lost.value.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" }) })}
    </div>
  );
}
