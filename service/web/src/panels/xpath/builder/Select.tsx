/** A choice of names, with how many clips have each. */
import { w } from "../../../words";
import type { Choice } from "./choices";

export function Select({
  label,
  value,
  choices,
  textOf = (name) => name,
  onFocus,
  onChange,
}: {
  label: string;
  value: string;
  choices: readonly Choice[];
  textOf?: (name: string) => string;
  onFocus?: () => void;
  onChange: (value: string) => void;
}) {
  const all = choices.some((one) => one.text === value) ? choices : [{ text: value, count: null }, ...choices];
  return (
    <select
      class="field builder-name"
      aria-label={label}
      value={value}
      onFocus={onFocus}
      onChange={(event) => onChange(event.currentTarget.value)}
    >
      {all.map((one) => (
        <option key={one.text} value={one.text}>
          {(one.text ? textOf(one.text) : "–") + (one.count === null ? "" : ` (${w("label.clips", { n: one.count })})`)}
        </option>
      ))}
    </select>
  );
}

/** A choice of few words. */
export function Words<T extends string>({
  label,
  value,
  words,
  onChange,
}: {
  label: string;
  value: T;
  words: Readonly<Record<T, string>>;
  onChange: (value: T) => void;
}) {
  return (
    <select
      class="field"
      aria-label={label}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value as T)}
    >
      {(Object.keys(words) as T[]).map((one) => (
        <option key={one} value={one}>
          {words[one]}
        </option>
      ))}
    </select>
  );
}
