/** Why a file was refused, where, and how to mend it. */
import type { Upload } from "../../../state/importing/uploads";
import { reasonOf } from "../../../state/importing/report";
import { w } from "../../../words";

export function Refusal({ refused }: { refused: Upload["problems"][number] }) {
  const { line, element, title, detail, remedy } = reasonOf(refused);
  return (
    <div class="refusal">
      <strong>{title}</strong>{" "}
      <span class="dim">{[line && w("label.line", { n: line }), element].filter(Boolean).join(", ")}</span>
      {detail && <p>{detail}</p>}
      {remedy && <p>{remedy}</p>}
    </div>
  );
}
