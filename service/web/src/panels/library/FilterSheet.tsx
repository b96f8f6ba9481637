/** The filters on a narrow screen: a button with their number, and a sheet that holds them. */
import { useState } from "preact/hooks";
import * as library from "../../state/library/library";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { number, w } from "../../words";
import { Facets } from "./Facets";
import { i } from "./words";

export function FilterSheet() {
  const [open, setOpen] = useState(false);
  const active = Object.values(library.filter.value).flat().length;
  const total = library.total.value;
  return (
    <>
      <button
        type="button"
        class="button filter-button"
        aria-haspopup="dialog"
        aria-label={active ? i("label.filtersActive", { n: active }) : w("label.filters")}
        onClick={() => setOpen(true)}
      >
        <Icon name="filter" />
        {active > 0 && <span class="filter-count">{number(active)}</span>}
      </button>
      {open && (
        <Dialog title={w("label.filters")} onClose={() => setOpen(false)} wide>
          <div class="filter-sheet">
            <Facets />
          </div>
          <p class="row filter-sheet-end">
            <button
              type="button"
              class="button primary grow"
              onClick={(event) => event.currentTarget.closest("dialog")?.close()}
            >
              {total === null ? w("label.loading") : i("button.showClips", { n: total })}
            </button>
          </p>
        </Dialog>
      )}
    </>
  );
}
