/** Who asks, and what they may do as far as the studio shows it; the server decides. Asked once a visit. */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../../api/client";

const me = signal<Schemas["Me"] | null>(null);
let asked: Promise<Schemas["Me"] | null> | null = null;

/** Null where the server does not say. */
export const askMe = () =>
  (asked ??= get("/account").then(
    (found) => (me.value = found),
    () => null,
  ));

/** Whether the server asks programs for a token: it does of who is here by an account or a token. */
export const needsToken = () => Boolean(me.value && (me.value.role || me.value.name !== "local"));

/** Whether they may change anything; true until it is known. */
export const mayEdit = () => me.value?.rights.includes("edit") ?? true;
