/** Names that were recognised in the motion, to accept one by one or all. */
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { get, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { number, w } from "../../../words";
import { newSpan } from "../actions";

type Suggested = Schemas["SuggestedLabels"]["items"][number];
export const suggested = signal<Suggested[]>([]);

export function Suggestions({ clip }: { clip: Clip }) {
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    suggested.value = [];
  }, [clip]);
  const offer = async () => {
    setBusy(true);
    try {
      const answer = await get("/documents/{id}/labels/suggested", { path: { id: clip.id } });
      suggested.value = answer.items;
      if (!answer.items.length) note(w("help.suggestionsNone"));
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  const all = suggested.value;
  const accept = () => {
    clip.setLabels([...clip.labels.peek(), ...all.map((one) => newSpan(one.name, one.first, one.last))]);
    suggested.value = [];
  };
  if (clip.pinned !== null || clip.skeleton.view.markers) return null;
  return (
    <div class="suggest row">
      {all.length ? (
        <>
          <button type="button" class="button dense" onClick={accept}>
            {w("button.acceptAll", { n: all.length })}
          </button>
          <button type="button" class="button quiet dense" onClick={() => (suggested.value = [])}>
            {w("button.hideSuggestions")}
          </button>
        </>
      ) : (
        <button type="button" class="button quiet dense" disabled={busy} onClick={() => void offer()}>
          {busy ? w("label.loading") : w("button.suggestions")}
        </button>
      )}
    </div>
  );
}

function Chip({ span, style, clip }: { span: Suggested; style: Record<string, string>; clip: Clip }) {
  return (
    <div role="listitem" class="span-item" style={style}>
      <button
        type="button"
        class="span offer"
        title={`${span.name} ${span.first}–${span.last}, ${w("label.confidence", { value: number(span.confidence, 2) })}: ${w("button.accept")}`}
        onClick={() => {
          clip.setLabels([...clip.labels.peek(), newSpan(span.name, span.first, span.last)]);
          suggested.value = suggested
            .peek()
            .filter((one) => one !== span && !(one.name === span.name && one.first === span.first));
        }}
      >
        {span.name}? {number(span.confidence, 2)}
      </button>
    </div>
  );
}
Suggestions.Chip = Chip;
