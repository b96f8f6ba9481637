/** A number in a field. What is typed stays while the page is drawn again; it counts on Enter, or when the field is left. */
import { useState } from "preact/hooks";

export function NumberField({
  label,
  value,
  least,
  most,
  step = "any",
  placeholder,
  onChange,
}: {
  /** Where no label stands around it. */
  label?: string;
  value: number | null;
  least?: number;
  most?: number;
  step?: number | "any";
  placeholder?: string;
  /** null: the field was emptied. */
  onChange: (value: number | null) => void;
}) {
  const [typed, setTyped] = useState<string | null>(null);
  return (
    <input
      class="field number"
      type="number"
      aria-label={label}
      min={least}
      max={most}
      step={step}
      placeholder={placeholder}
      value={typed ?? value ?? ""}
      onInput={(event) => setTyped(event.currentTarget.value)}
      onChange={(event) => {
        setTyped(null);
        onChange(Number.isFinite(event.currentTarget.valueAsNumber) ? event.currentTarget.valueAsNumber : null);
      }}
    />
  );
}
