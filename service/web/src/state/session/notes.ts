/** Toasts: what was done, with a way back. Trouble that needs a decision stands in the page instead. */
import { signal } from "@preact/signals";
import { ApiError, Offline } from "../../api/client";
import { w } from "../../words";

export interface Note {
  id: number;
  text: string;
  detail?: string;
  bad?: boolean;
  action?: { text: string; run: () => void };
}

export const notes = signal<Note[]>([]);
let last = 0;

const SECONDS = 6;
const SECONDS_WITH_UNDO = 10;
const MOST = 3;

export function note(text: string, more: Omit<Note, "id" | "text"> = {}): void {
  const one = { id: ++last, text, ...more };
  notes.value = [...notes.value, one].slice(-MOST);
  const seconds = more.bad ? SECONDS_WITH_UNDO * 2 : more.action ? SECONDS_WITH_UNDO : SECONDS;
  setTimeout(() => dismiss(one.id), seconds * 1000);
}

export function dismiss(id: number): void {
  if (held.has(id)) setTimeout(() => dismiss(id), 1000);
  else notes.value = notes.value.filter((one) => one.id !== id);
}

/** Toasts under the pointer or with the focus; they stay. */
export const held = new Set<number>();

/** Copy a text and say so. */
export async function copyText(text: string, said: string): Promise<void> {
  await navigator.clipboard.writeText(text);
  note(said);
}

/** Say what went wrong, in the server's words with its remedy. Aborted requests are no trouble. */
export function refuse(error: unknown): void {
  if ((error as Error)?.name === "AbortError") return;
  // Of preconditions the server tells programs; a person is told what happened.
  if (error instanceof ApiError && error.status === 412)
    note(w("error.staleWrite"), {
      detail: w("error.staleHelp"),
      bad: true,
      action: { text: w("button.reload"), run: () => location.reload() },
    });
  else if (error instanceof ApiError) note(error.message, { detail: error.remedy, bad: true });
  else if (error instanceof Offline) note(error.message, { bad: true });
  else {
    note(String((error as Error)?.message ?? error), { bad: true });
    console.error(error);
  }
}
