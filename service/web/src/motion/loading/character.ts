/** Bodies with a skin, to the measure of documents' skeletons. Each is asked for once. */
import { signal, type ReadonlySignal, type Signal } from "@preact/signals";
import { get } from "../../api/client";
import { skinOf, type Skin } from "../body/skin";

export interface Character {
  skin: Skin | null;
  /** Why there is none, and what helps. */
  reason: string;
}

const MOST = 16;
const asked = new Map<string, Signal<Character | null>>();

/** The body of a document at a revision; null while it is on its way. */
export function characterOf(id: string, revision: number): ReadonlySignal<Character | null> {
  const key = `${id}@${revision}`;
  const before = asked.get(key);
  if (before) return before;
  const made = signal<Character | null>(null);
  asked.set(key, made);
  const [oldest] = asked.keys();
  if (asked.size > MOST && oldest !== undefined) asked.delete(oldest);
  void load(id, revision).then(
    (found) => (made.value = found),
    (error: unknown) => {
      asked.delete(key);
      made.value = { skin: null, reason: (error as Error).message };
    },
  );
  return made;
}

async function load(id: string, revision: number): Promise<Character> {
  const { mesh, reason, remedy } = await get("/documents/{id}/character", { path: { id }, query: { revision } });
  return { skin: mesh ? skinOf(mesh) : null, reason: [reason, remedy].filter(Boolean).join(" ") };
}
