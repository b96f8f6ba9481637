/** Edges that are dragged: which frame one comes to, snapping to named stretches; Alt does not snap. */
import { snapped, type Stretch } from "../../state/editing/composition";

const EDGE = 8; // px at either end
const REACH = 8; // px within which an edge snaps

export interface Range {
  first: number;
  last: number;
  frames: number;
}
export interface Trial {
  key: number;
  first: number;
  last: number;
  at: number;
  edge: "first" | "last" | "move";
  name: string | null;
}

/** Which edge of a box the pointer is at. */
export function edgeAt(event: PointerEvent, box: DOMRect): "first" | "last" | null {
  const edge = Math.min(EDGE, box.width / 3);
  return event.clientX - box.left < edge ? "first" : box.right - event.clientX < edge ? "last" : null;
}

/** The range with one edge moved by so many pixels. */
export function trimmed(
  range: Range,
  edge: "first" | "last",
  pixels: number,
  perPixel: number,
  spans: readonly Stretch[],
  free: boolean,
): { first: number; last: number; name: string | null } {
  const [least, most] = edge === "first" ? [1, range.last] : [range.first, range.frames];
  const wanted = Math.max(least, Math.min(most, Math.round(range[edge] + pixels * perPixel)));
  const there = free ? { frame: wanted, name: null } : snapped(wanted, edge, spans, REACH * perPixel);
  const inside = there.frame >= least && there.frame <= most;
  return {
    first: range.first,
    last: range.last,
    [edge]: inside ? there.frame : wanted,
    name: inside ? there.name : null,
  };
}

/** Follow the pointer until it is let go. cancelled: Esc, or the browser took it. */
export function follow(
  event: PointerEvent,
  onMove: (pixels: number, event: PointerEvent) => void,
  onEnd: (cancelled: boolean, event: PointerEvent | null) => void,
): void {
  const element = event.currentTarget as HTMLElement;
  element.setPointerCapture(event.pointerId);
  const end = (cancelled: boolean, last: PointerEvent | null) => {
    element.onpointermove = element.onpointerup = element.onpointercancel = null;
    removeEventListener("keydown", onKey, true);
    onEnd(cancelled, last);
  };
  const onKey = (pressed: KeyboardEvent) => {
    if (pressed.key !== "Escape") return;
    pressed.stopPropagation();
    end(true, null);
  };
  addEventListener("keydown", onKey, true);
  element.onpointermove = (move) => onMove(move.clientX - event.clientX, move);
  element.onpointerup = (up) => end(false, up);
  element.onpointercancel = () => end(true, null);
}
