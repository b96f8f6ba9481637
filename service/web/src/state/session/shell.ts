/** What the frame around the pages shows, and what a page tells it. */
import { signal } from "@preact/signals";

/** What the open page is about, such as the clip's name. */
export const subject = signal<{ text: string; detail?: string } | null>(null);

/** Whether the table of keys is open. */
export const keysOpen = signal(false);

/** Whether the rail is open in a narrow window. */
export const drawerOpen = signal(false);

/** The text that the palette opens with; null: it is closed. */
export const paletteOpen = signal<string | null>(null);

/** Of the open clip: go to a frame (from 1) or to seconds. */
export const timeJump = signal<((text: string) => void) | null>(null);
