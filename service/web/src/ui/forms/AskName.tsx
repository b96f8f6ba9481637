/** Ask for a name under which something is kept. */
import { useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { refuse } from "../../state/session/notes";
import { Dialog } from "../Dialog";
import { w } from "../../words";

export function AskName({
  title,
  initial = "",
  label = w("label.name"),
  verb = w("button.save"),
  names,
  children,
  onName,
  onClose,
}: {
  title: string;
  initial?: string;
  /** Of the field. */
  label?: string;
  /** On the button. */
  verb?: string;
  /** Names that complete the text. */
  names?: (text: string) => string[];
  /** What is kept, above the field. */
  children?: ComponentChildren;
  /** Refusals are told; the dialog stays open. */
  onName: (name: string) => Promise<void>;
  onClose: () => void;
}) {
  const [name, setName] = useState(initial);
  const [busy, setBusy] = useState(false);
  const keep = async () => {
    setBusy(true);
    try {
      await onName(name.trim());
      onClose();
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={title} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (name.trim() && !busy) void keep();
        }}
      >
        {children}
        <p class="row">
          <input
            class="field grow"
            autoFocus
            list={names && "asked-names"}
            aria-label={label}
            placeholder={label}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button type="submit" class="button primary" disabled={!name.trim() || busy}>
            {verb}
          </button>
        </p>
        {names && (
          <datalist id="asked-names">
            {names(name.trim()).map((one) => (
              <option key={one} value={one} />
            ))}
          </datalist>
        )}
      </form>
    </Dialog>
  );
}
