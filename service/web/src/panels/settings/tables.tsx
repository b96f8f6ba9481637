/** Tables of people, tokens and links, and words for what they may do. */
import type { ComponentChildren } from "preact";
import { language } from "../../state/session/settings";
import { copyText } from "../../state/session/notes";
import { w, type Word } from "../../words";

export const day = (iso: string): string =>
  new Intl.DateTimeFormat(language.value, { dateStyle: "medium" }).format(new Date(iso));
export const ROLE_WORDS: Record<string, Word> = {
  member: "label.roleMember",
  reader: "label.roleReader",
  editor: "label.roleEditor",
  owner: "label.roleOwner",
};

export function Table({ head, rows }: { head: string[]; rows: ComponentChildren[][] }) {
  if (!rows.length) return null;
  return (
    <table class="account-table">
      <thead>
        <tr>
          {head.map((one, at) => (
            <th key={at}>{one}</th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((cells, row) => (
          <tr key={row}>
            {cells.map((cell, at) => (
              <td key={at}>{cell}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** What is shown this once. */
export function Secret({ text, label }: { text: string; label: string }) {
  return (
    <p class="row wrap account-secret">
      <span>{label}</span>
      <code>{text}</code>
      <button type="button" class="button dense" onClick={() => void copyText(text, w("label.copied"))}>
        {w("button.copy")}
      </button>
    </p>
  );
}
