/** What becomes of dropped files, where a page takes them for itself; null: they are clips for the library. */
import { signal } from "@preact/signals";

export const dropHere = signal<{ title: string; help: string; take: (files: File[]) => void } | null>(null);

/** The same for files that are dropped on a field of their own, beside that of the library; null: there is none. */
export const dropOnto = signal<{ title: string; help: string; take: (files: File[]) => void } | null>(null);
