/** What is known of the clips of a storyboard: asked once each. */
import { signal } from "@preact/signals";
import { get } from "../../api/client";
import { usualPart } from "../../motion/body/parts";
import type { Skeleton } from "../../motion/body/skeleton";
import { motionOf } from "../../motion/loading/source";
import type { Stretch } from "../../state/editing/composition";
import { refuse } from "../../state/session/notes";

export interface Facts {
  name: string;
  frames: number;
  perSecond: number;
  skeleton: Skeleton;
  /** What a layer on this body takes at first. */
  bones: readonly string[];
  spans: readonly Stretch[];
}

export const facts = signal<ReadonlyMap<string, Facts>>(new Map());
const asked = new Set<string>();

export function askFacts(documents: Iterable<string>): void {
  for (const id of documents) if (!asked.has(id)) void load(id);
}

async function load(id: string): Promise<void> {
  asked.add(id);
  try {
    const [motion, document] = await Promise.all([motionOf(id), get("/documents/{id}", { path: { id } })]);
    const { name, frames, perSecond, skeleton } = motion;
    facts.value = new Map(facts.peek()).set(id, {
      name,
      frames,
      perSecond,
      skeleton,
      bones: usualPart(skeleton.view.bones),
      spans: document.labels,
    });
  } catch (error) {
    asked.delete(id);
    refuse(error);
  }
}
