/** Picking cards with Ctrl and Shift, as in file managers. */
import * as library from "../../state/library/library";

let anchor = -1;

/** Pick a card, or the range up to it; false: the click opens it. */
export function pickBy(event: MouseEvent, row: number, id: string): boolean {
  if (event.shiftKey && anchor >= 0) {
    void library.pickRows(Math.min(anchor, row), Math.max(anchor, row));
    return true;
  }
  anchor = row;
  if (!event.ctrlKey && !event.metaKey) return false;
  library.pick(id);
  return true;
}
