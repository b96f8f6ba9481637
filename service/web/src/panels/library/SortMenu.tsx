/** By what the library is ordered, and in which direction; headings of the list say and do the same. */
import * as library from "../../state/library/library";
import { setParams } from "../../state/session/route";
import { asSort, COLUMNS, pressed, type Column, type Order } from "../../state/library/sorting";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { w, type Word } from "../../words";

function sortBy(order: Order): void {
  const sort = asSort(order);
  setParams({ sort: sort === "newest" ? null : sort });
}

export function SortMenu() {
  const order = library.order.value;
  const items = (Object.keys(COLUMNS) as Column[]).map((column) => ({
    text: w(COLUMNS[column].word),
    checked: column === order.column,
    run: () => {
      if (column !== order.column) sortBy(pressed(order, column));
    },
  }));
  const direction = w(order.down ? "label.descending" : "label.ascending");
  return (
    <span class="row sort">
      <Menu label={w("label.sort")} className="button quiet" items={items}>
        <span class="cut">{w(COLUMNS[order.column].word)}</span>
        <Icon name="down" />
      </Menu>
      <button
        type="button"
        class="button quiet icon"
        title={direction}
        aria-label={`${w("label.sort")}: ${direction}`}
        onClick={() => sortBy({ ...order, down: !order.down })}
      >
        <Arrow down={order.down} />
      </button>
    </span>
  );
}

/** The heading of a column of the list. */
export function SortHeading({
  column,
  word = COLUMNS[column].word,
  numeric = false,
}: {
  column: Column;
  word?: Word;
  numeric?: boolean;
}) {
  const order = library.order.value;
  const now = order.column === column ? (order.down ? "descending" : "ascending") : null;
  return (
    <span class={numeric ? "n" : ""}>
      <button
        type="button"
        class={`sort-heading ${now ? "now" : ""}`}
        aria-label={`${w("label.sort")}: ${w(word)}${now ? `, ${w(`label.${now}`)}` : ""}`}
        aria-pressed={now !== null}
        onClick={() => sortBy(pressed(order, column))}
      >
        <span class="cut">{w(word)}</span>
        {now && <Arrow down={order.down} />}
      </button>
    </span>
  );
}

function Arrow({ down }: { down: boolean }) {
  return (
    <span class={down ? "arrow" : "arrow up"}>
      <Icon name="arrow" />
    </span>
  );
}
