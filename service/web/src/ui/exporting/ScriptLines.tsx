/** The line that does the same in a script, in the language that a person chooses, to copy. */
import { useState } from "preact/hooks";
import { copyText } from "../../state/session/notes";
import { w } from "../../words";
import "../../styles/shared.css";

type Language = "Python" | "Command" | "Curl";

/** lines: by language, in the order of the buttons. */
export function ScriptLines({ lines }: { lines: Partial<Record<Language, string>> }) {
  const languages = Object.keys(lines) as Language[];
  const [chosen, setChosen] = useState(languages[0]);
  const line = (chosen && lines[chosen]) ?? "";
  return (
    <div class="script-lines">
      <div class="row" role="group" aria-label={w("label.inScripts")}>
        <strong>{w("label.inScripts")}</strong>
        {languages.map((one) => (
          <button
            key={one}
            type="button"
            class="button quiet dense"
            aria-pressed={chosen === one}
            onClick={() => setChosen(one)}
          >
            {w(`label.as${one}`)}
          </button>
        ))}
        <span class="grow" />
        <button type="button" class="button dense" onClick={() => void copyText(line, w("label.copied"))}>
          {w("button.copy")}
        </button>
      </div>
      <pre class="script-line" tabIndex={0} aria-label={w("label.inScripts")}>
        {line}
      </pre>
    </div>
  );
}
