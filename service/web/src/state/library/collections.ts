/** Collections of documents: lists that ask for them look again when this moves. */
import { signal } from "@preact/signals";

export const collectionsChanged = signal(0);
