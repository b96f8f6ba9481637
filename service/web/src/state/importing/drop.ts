/** What becomes of dropped files, where a page takes them for itself; null: they are clips for the library. */
import { signal } from "@preact/signals";

export const dropHere = signal<{ title: string; help: string; take: (files: File[]) => void } | null>(null);
