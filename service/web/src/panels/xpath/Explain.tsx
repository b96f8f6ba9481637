/** How the server evaluated a query. */
import { w } from "../../words";

export function Explain({ explain }: { explain: unknown }) {
  if (!explain) return null;
  const rows = Object.entries(explain as Record<string, unknown>).filter(
    ([, value]) => value !== null && value !== undefined && value !== "",
  );
  return (
    <details class="explain">
      <summary class="button quiet dense">{w("label.explain")}</summary>
      <dl>
        {rows.map(([name, value]) => (
          <div key={name}>
            <dt>{name.replaceAll("_", " ")}</dt>
            <dd>{typeof value === "object" ? <code>{JSON.stringify(value)}</code> : String(value)}</dd>
          </div>
        ))}
      </dl>
    </details>
  );
}
