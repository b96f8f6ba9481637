/** In which order the library stands: a column, and whether from its greatest value down. */
import type { Word } from "../../words";

/** `down`: the direction that one wants first. Imports go by `newest`, which is exact, and `created`. */
export const COLUMNS = {
  created: { word: "label.importedWord", down: true },
  name: { word: "label.name", down: false },
  modified: { word: "label.changedWord", down: true },
  duration: { word: "label.length", down: true },
  frames: { word: "label.framesWord", down: true },
  rate: { word: "label.frameRate", down: true },
  project: { word: "label.project", down: false },
  format: { word: "label.format", down: false },
  skeleton: { word: "label.skeleton", down: false },
  revision: { word: "label.revisionsWord", down: true },
} as const satisfies Record<string, { word: Word; down: boolean }>;

export type Column = keyof typeof COLUMNS;
export type Sort = "newest" | `${"" | "-"}${Column}`;
export interface Order {
  column: Column;
  down: boolean;
}

export const NEWEST: Order = { column: "created", down: true };

/** What the address says; the newest first where it says nothing that is known. */
export function asOrder(text: string): Order {
  const down = text.startsWith("-");
  const column = down ? text.slice(1) : text;
  return Object.hasOwn(COLUMNS, column) ? { column: column as Column, down } : NEWEST;
}

/** The same as the server takes it. */
export function asSort({ column, down }: Order): Sort {
  return column === "created" && down ? "newest" : `${down ? "-" : ""}${column}`;
}

/** What a press on a column means: its own direction first, then the other one. */
export function pressed(now: Order, column: Column): Order {
  return { column, down: now.column === column ? !now.down : COLUMNS[column].down };
}
