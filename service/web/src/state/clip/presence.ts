/**
 * Who else has the open clip open, and who edits it: said and heard with one request every 20 seconds. Without an
 * account, as alone on one's own machine, nothing is sent.
 */
import { effect, signal } from "@preact/signals";
import { address, ask, type Schemas } from "../../api/client";
import { askMe } from "../session/me";

export type Present = Schemas["Present"];

/** Others at the clip that is open. */
export const others = signal<Present[]>([]);
/** Whether this window changes it. */
export const editing = signal(false);

const PATH = "/documents/{id}/presence";
const BEAT = 20_000;
const tab = Math.random().toString(36).slice(2);

const hasAccount = async () => ((await askMe())?.role ?? null) !== null;
/** Requests go one after the other, so that the last one counts. */
let turn: Promise<unknown> = Promise.resolve();

/** Be at a clip, until what this answers is called. */
export function bePresent(id: string): () => void {
  let over = false;
  const beat = () => {
    // What a window shows that nobody sees is looked at by nobody; what is changed there can still be saved.
    if (over || (document.hidden && !editing.peek())) return;
    turn = turn.then(async () => {
      if (over || !(await hasAccount())) return;
      try {
        const doing = editing.peek() ? "editing" : "viewing";
        const heard = await ask("put", PATH, { path: { id }, body: { doing, tab } });
        if (!over) others.value = heard.items;
      } catch {
        // The server is away, or the session has ended: other requests say so.
        others.value = [];
      }
    });
  };
  const leave = () => {
    turn = turn.then(async () => {
      // As the page goes: not waited for.
      if (await hasAccount())
        void fetch(address(PATH, { id }, { tab }), { method: "DELETE", keepalive: true }).catch(() => undefined);
    });
  };
  const timer = setInterval(beat, BEAT);
  const stop = effect(() => {
    void editing.value;
    beat();
  });
  document.addEventListener("visibilitychange", beat);
  addEventListener("pagehide", leave);
  return () => {
    over = true;
    clearInterval(timer);
    stop();
    document.removeEventListener("visibilitychange", beat);
    removeEventListener("pagehide", leave);
    others.value = [];
    leave();
  };
}
