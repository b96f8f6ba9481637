/** The answer as a table: frame ranges or items; what is picked is played or read beside it. */
import type { HTMLAttributes } from "preact";
import { useMemo, useState } from "preact/hooks";
import { go } from "../../state/session/route";
import { RunPlayer } from "../../ui/playing/RunPlayer";
import { VirtualList } from "../../ui/VirtualList";
import { number, w } from "../../words";
import { HitCards } from "./HitCards";
import { sortRuns, type Order } from "./rangeTable";
import { RunHead } from "./RunHead";
import { ItemCells, ItemHead, OneValue, shapeOf, WholeValue, type Item } from "./Answer";
import type { Answered, Run } from "./answered";

const DIGITS = 2;

/** Open a frame range or the document of an item. */
function open(one: Run | Item | undefined): void {
  if (!one?.document) return;
  if ("frames" in one) go(`/clips/${one.document}?f=${one.first}&in=${one.first}&out=${one.last}`);
  else go(`/clips/${one.document}`);
}

/** found: the runs of the answer; none where it is of another kind. isOld: the query has changed since. onEnd: its last rows are in
 * sight. */
export function AnswerTable({
  answer,
  runs: found,
  isOld,
  onEnd,
}: {
  answer: Answered;
  runs: Run[];
  isOld: boolean;
  onEnd: () => void;
}) {
  const [chosen, setPicked] = useState(0);
  const [order, setOrder] = useState<Order | null>(null);
  const runs = useMemo(() => sortRuns(found, order), [found, order]);
  const picked = Math.min(chosen, Math.max(0, answer.items.length - 1));
  const at = (row: number): Run | Item | undefined =>
    answer.as === "runs" ? runs[row] : (answer.items as Item[])[row];
  const items = useMemo(() => (answer.as === "json" ? (answer.items as Item[]) : []), [answer]);
  const shape = useMemo(() => shapeOf(items), [items]);
  if (!answer.items.length) {
    return (
      <div class="empty">
        <h2>{w("label.noAnswer")}</h2>
        <p>{w("help.noAnswerHelp")}</p>
      </div>
    );
  }
  if (answer.single && items[0]) return <OneValue item={items[0]} />;
  return (
    <div class={`xpath-answer${isOld ? " old" : ""}`} aria-busy={isOld}>
      <div class={`xpath-table${answer.rangeOf ? " with-figures" : ""}`}>
        {answer.as === "json" && <ItemHead shape={shape} />}
        {answer.as === "runs" && (
          <>
            <HitCards runs={runs} picked={picked} onPick={setPicked} />
            <RunHead
              rangeOf={answer.rangeOf}
              order={order}
              loaded={answer.cursor ? runs.length : null}
              onOrder={(next) => {
                setOrder(next);
                setPicked(0);
              }}
            />
          </>
        )}
        <VirtualList
          rows={answer.items.length}
          height={28}
          label={w("label.results")}
          role="listbox"
          at={picked}
          onSeen={(_, last) => {
            if (last >= answer.items.length - 5) onEnd();
          }}
          onKeyDown={(event) => {
            const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
            if (step) {
              setPicked(Math.max(0, Math.min(answer.items.length - 1, picked + step)));
              event.preventDefault();
            }
            if (event.key === "Enter") open(at(picked));
          }}
          render={(row) => {
            const item = at(row);
            if (!item) return null;
            const props = {
              role: "option",
              "aria-selected": row === picked,
              tabIndex: row === picked ? 0 : -1,
              onClick: () => setPicked(row),
              onDblClick: () => open(item),
            } as const;
            return answer.as === "runs" ? (
              <RunRow run={item as Run} row={row} figures={answer.rangeOf !== null} {...props} />
            ) : (
              <div class={`run-row of-${shape}`} {...props}>
                <ItemCells item={item} row={row} />
              </div>
            );
          }}
        />
      </div>
      {items[picked] && <WholeValue item={items[picked]} />}
      {runs.length > 0 && <RunPlayer runs={runs} at={picked} onAt={setPicked} />}
    </div>
  );
}

function RunRow({
  run,
  row,
  figures,
  ...props
}: { run: Run; row: number; figures: boolean } & HTMLAttributes<HTMLDivElement>) {
  return (
    <div class="run-row" {...props}>
      <span class="n dim">{number(row + 1)}</span>
      <span class="cut">{run.name}</span>
      <span class="n">{number(run.first)}</span>
      <span class="n">{number(run.last)}</span>
      <span class="n dim">{number(run.frames)}</span>
      {figures &&
        [run.range?.[0], run.range?.[1], run.mean].map((value, at) => (
          <span key={at} class="n figure">
            {typeof value === "number" ? number(value, DIGITS) : "–"}
          </span>
        ))}
    </div>
  );
}
