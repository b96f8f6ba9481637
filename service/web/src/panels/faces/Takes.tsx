/** The clips of the expression space by name, each shown or dimmed. */
import { setParams } from "../../state/session/route";
import { type Space } from "./space";
import { f } from "./words";

/** Takes by name, with their colours; those that are not looked at are dimmed. */
export function Takes({ space, dimmed }: { space: Space; dimmed: ReadonlySet<number> }) {
  const write = (next: Set<number>) => setParams({ takes: [...next].join(",") || null });
  return (
    <details class="faces-takes">
      <summary class="button dense">
        {f("label.takes")} {space.names.length - dimmed.size}/{space.names.length}
      </summary>
      <ul>
        <li>
          <button type="button" class="button dense" onClick={() => write(new Set())}>
            {f("label.allTakes")}
          </button>
        </li>
        {space.names.map((name, at) => (
          <li key={at}>
            <label class="row">
              <input
                type="checkbox"
                checked={!dimmed.has(at)}
                onChange={(event) => {
                  const next = new Set(dimmed);
                  if (event.currentTarget.checked) next.delete(at);
                  else next.add(at);
                  write(next);
                }}
              />
              <span class="swatch" style={{ background: `var(--name${at % 8})` }} />
              {name}
            </label>
          </li>
        ))}
      </ul>
    </details>
  );
}
