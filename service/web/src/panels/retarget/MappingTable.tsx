/** Which joint of the motion moves which joint of the body; doubtful ones first, each with its reason. */
import { numberAt } from "../../lists";
import type { Schemas } from "../../api/client";
import { SIDE_TOKENS, type Skeleton } from "../../motion/body/skeleton";
import { number, w } from "../../words";

export interface Pair {
  source: string;
  target: string;
}
const DOUBTFUL = 0.9;

export function MappingTable({
  source,
  target,
  pairs,
  matches,
  selected,
  onSelect,
  onChange,
}: {
  source: Skeleton;
  target: Skeleton;
  pairs: Pair[];
  matches: Schemas["JointMatch"][];
  selected: string | null;
  onSelect: (source: string | null) => void;
  onChange: (pairs: Pair[]) => void;
}) {
  const why = new Map(matches.map((one) => [one.target, one]));
  const by = new Map(pairs.map((one) => [one.target, one.source]));
  const rows = target.view.bones.map((bone, index) => ({
    bone: bone.name,
    side: SIDE_TOKENS[numberAt(target.sides, index)],
    from: by.get(bone.name) ?? "",
    match: why.get(bone.name),
  }));
  const weight = (row: (typeof rows)[number]) => (row.from ? (row.match?.confidence ?? 1) : 2);
  rows.sort((a, b) => weight(a) - weight(b));
  const set = (bone: string, from: string) =>
    onChange([...pairs.filter((one) => one.target !== bone), ...(from ? [{ source: from, target: bone }] : [])]);
  return (
    <div class="mapping">
      <table>
        <thead>
          <tr>
            <th>{w("label.targetClip")}</th>
            <th>{w("label.sourceClip")}</th>
            <th class="n">{w("label.confidenceWord")}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr
              key={row.bone}
              class={row.from && row.from === selected ? "chosen" : ""}
              onClick={() => onSelect(row.from || null)}
            >
              <td>
                <span class="row">
                  <span class="dot" style={{ background: `var(--${row.side})` }} />
                  {row.bone}
                </span>
              </td>
              <td>
                <select
                  class="field"
                  aria-label={row.bone}
                  value={row.from}
                  onChange={(event) => set(row.bone, event.currentTarget.value)}
                >
                  <option value="">{w("label.notMapped")}</option>
                  {source.view.bones.map((one) => (
                    <option key={one.name} value={one.name}>
                      {one.name}
                    </option>
                  ))}
                </select>
              </td>
              <td class="n" title={row.match?.reason}>
                {row.from && row.match && (
                  <span class={row.match.confidence < DOUBTFUL ? "guess" : "dim"}>
                    {number(row.match.confidence, 2)}
                  </span>
                )}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
