/** Queries to begin with, from this library: each finds frames in it. */
import type { Schemas } from "../../api/client";
import { Trouble } from "../../ui/Trouble";
import type { Loaded } from "../../ui/useAsync";
import { number, w } from "../../words";
import { activityText, angleText, capital, jointText } from "../../ui/bodies/bodyNames";
import { x, type QueryWord } from "./words";

type Example = Schemas["QueryExample"];

const WORDS: Record<Example["kind"], QueryWord> = {
  activity: "label.exampleActivity",
  "speed-contact": "label.exampleSpeedContact",
  "above-head": "label.exampleAboveHead",
  angle: "label.exampleAngle",
  then: "label.exampleThen",
  distance: "label.exampleDistance",
  fastest: "label.exampleFastest",
  height: "label.exampleHeight",
  speed: "label.exampleSpeed",
  label: "label.exampleLabel",
  "no-label": "label.exampleNoLabel",
  begin: "label.exampleBegin",
  every: "label.exampleEvery",
};

/** The frames that an example finds, in the language of the page. */
export function exampleText({ kind, values }: Example): string {
  const words = Object.entries(values).map(([name, value]) => {
    if (typeof value === "number") return [name, number(value, 2)];
    if (name === "joint" || name === "other") return [name, jointText(value)];
    if (name === "angle") return [name, angleText(value)];
    return [name, kind === "activity" ? activityText(value) : value];
  });
  return capital(x(WORDS[kind], Object.fromEntries(words) as Record<string, string>));
}

export function Examples({
  found,
  onChoose,
}: {
  found: Loaded<Schemas["QueryExamples"]>;
  onChoose: (query: string) => void;
}) {
  const items = found.value?.items ?? [];
  return (
    <div class="empty examples-page">
      <h2>{w("help.xpathStart")}</h2>
      <Trouble error={found.error} retry={found.again} />
      {items.length > 0 && <p class="dim">{w("label.xpathExamples")}</p>}
      {found.busy && !items.length && (
        <p class="dim" role="status">
          {x("label.lookingForExamples")}
        </p>
      )}
      {found.value && !items.length && <p class="dim">{x("help.noExamples")}</p>}
      <ul class="examples">
        {items.map((one) => (
          <li key={one.q}>
            <button type="button" class="example" onClick={() => onChoose(one.q)}>
              <span>{exampleText(one)}</span>
              <code>{one.q}</code>
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}
