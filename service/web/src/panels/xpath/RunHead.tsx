/** The heads of the columns of frame ranges, which sort them. */
import { w } from "../../words";
import { COLUMNS, nextOrder, type Column, type Order } from "./rangeTable";
import { x } from "./words";

/** rangeOf: the quantity of the figures, as in the query. loaded: how many ranges are sorted, where more follow. */
export function RunHead({
  rangeOf,
  order,
  loaded,
  onOrder,
}: {
  rangeOf: string | null;
  order: Order | null;
  loaded: number | null;
  onOrder: (order: Order | null) => void;
}) {
  const head = (column: Column, text: string, title = text) => {
    const isMine = order?.column === column;
    const sign = isMine ? (order.falling ? " ▾" : " ▴") : "";
    const sortText = x("label.sortBy", { column: title });
    return (
      <button
        type="button"
        class={`run-sort${column === "name" ? "" : " n"}${COLUMNS.indexOf(column) > 3 ? " figure" : ""}`}
        aria-label={sortText}
        aria-pressed={isMine}
        title={loaded === null ? sortText : `${sortText}. ${x("help.sortsLoaded", { n: loaded })}`}
        onClick={() => onOrder(nextOrder(order, column))}
      >
        {text}
        {sign}
      </button>
    );
  };
  return (
    <div class="run-row run-head" role="group" aria-label={w("label.results")}>
      <span class="n" aria-hidden="true">
        #
      </span>
      {head("name", w("label.document"))}
      {head("first", w("label.from"))}
      {head("last", w("label.last"))}
      {head("frames", x("label.lengthFrames"))}
      {rangeOf !== null && (
        <>
          {head("least", x("label.minimum"), `${x("label.minimum")} ${rangeOf}`)}
          {head("most", x("label.maximum"), `${x("label.maximum")} ${rangeOf}`)}
          {head("mean", x("label.mean"), `${x("label.mean")} ${rangeOf}`)}
        </>
      )}
    </div>
  );
}
