/** Labels that were recognised in the motion, to accept one by one or all: activities by themselves, movements when asked. */
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { get, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { mayEdit } from "../../../state/session/me";
import { note, refuse } from "../../../state/session/notes";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { number, w } from "../../../words";
import { newSpan } from "../actions";

type Suggested = Schemas["SuggestedLabels"]["items"][number];
type Kind = "activities" | "movements";
export const suggested = signal<Suggested[]>([]);

/** Longer clips are looked through when asked only. */
const LONGEST_BY_ITSELF = 50_000;

/** Suggestions that say more than the labels that there are: a label of the same name covers half of the others. */
export function newSuggestions(
  all: Suggested[],
  labels: readonly { name: string; first: number; last: number }[],
): Suggested[] {
  return all.filter(
    (one) =>
      !labels.some(
        (label) =>
          label.name === one.name &&
          2 * (Math.min(label.last, one.last) - Math.max(label.first, one.first) + 1) > one.last - one.first + 1,
      ),
  );
}

export function Suggestions({ clip }: { clip: Clip }) {
  const [busy, setBusy] = useState(false);
  const mends = clip.pinned === null && mayEdit();
  useEffect(() => {
    suggested.value = [];
    if (!mends || clip.detail.frames > LONGEST_BY_ITSELF) return;
    const stop = new AbortController();
    get("/documents/{id}/labels/suggested", { path: { id: clip.id }, signal: stop.signal }).then(
      (answer) => {
        if (!stop.signal.aborted) suggested.value = answer.items;
      },
      // Nobody asked: what went wrong is told when somebody does.
      () => undefined,
    );
    return () => stop.abort();
  }, [clip, mends]);
  const offer = async (kind: Kind) => {
    setBusy(true);
    try {
      const answer = await get("/documents/{id}/labels/suggested", { path: { id: clip.id }, query: { kind } });
      suggested.value = answer.items;
      const warning = answer.warnings?.[0];
      if (!answer.items.length || warning) note(warning ?? w("help.suggestionsNone"));
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  const all = newSuggestions(suggested.value, clip.labels.value);
  const accept = () => {
    clip.setLabels([...clip.labels.peek(), ...all.map((one) => newSpan(one.name, one.first, one.last))]);
    suggested.value = [];
  };
  if (!mends) return null;
  return (
    <div class="suggest row">
      {all.length ? (
        <>
          <button type="button" class="button dense" onClick={accept}>
            {w("button.acceptAll", { n: all.length })}
          </button>
          <button
            type="button"
            class="button quiet icon dense"
            aria-label={w("button.hideSuggestions")}
            title={w("button.hideSuggestions")}
            onClick={() => (suggested.value = [])}
          >
            <Icon name="close" />
          </button>
        </>
      ) : busy ? (
        <span class="dim">{w("label.loading")}</span>
      ) : (
        <Menu
          label={w("button.suggestions")}
          className="button quiet dense"
          items={[
            { text: w("label.activities"), detail: w("help.activities"), run: () => void offer("activities") },
            {
              text: w("label.movements"),
              detail: w("help.movements"),
              disabled: clip.skeleton.view.markers,
              run: () => void offer("movements"),
            },
          ]}
        >
          {w("button.suggestions")}
          <Icon name="down" />
        </Menu>
      )}
    </div>
  );
}

/** The angle of a turn or a movement, the steps of a walk; nothing for others. */
function amountOf(span: Suggested): string {
  if (span.degrees != null) return ` ${number(span.degrees, 0)}°`;
  return span.steps == null || span.name === "step" ? "" : `, ${w("label.steps", { n: span.steps })}`;
}

function Chip({ span, style, clip }: { span: Suggested; style: Record<string, string>; clip: Clip }) {
  const text = `${span.name}${amountOf(span)}`;
  return (
    <div role="listitem" class="span-item" style={style}>
      <button
        type="button"
        class="span offer"
        title={`${text}, ${span.first}–${span.last}, ${w("label.confidence", { value: number(span.confidence, 2) })}: ${w("button.accept")}`}
        onClick={() => {
          clip.setLabels([...clip.labels.peek(), newSpan(span.name, span.first, span.last)]);
          suggested.value = suggested
            .peek()
            .filter((one) => one !== span && !(one.name === span.name && one.first === span.first));
        }}
      >
        {text}?
      </button>
    </div>
  );
}
Suggestions.Chip = Chip;
