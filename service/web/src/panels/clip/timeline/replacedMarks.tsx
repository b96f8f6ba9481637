/** Frames whose samples were just filled or replaced, marked on the ruler until they are hidden or the clip changes again. */
import { signal } from "@preact/signals";
import type { Schemas } from "../../../api/client";
import { toX, type Range } from "../../../motion/timeline/timeline";
import type { Clip } from "../../../state/clip/clip";
import { colour } from "../../../state/session/settings";
import { Icon } from "../../../ui/icons";
import { w } from "../../../words";

const TALL = 5; // px
const NARROWEST = 2; // px

/** From 1, both ends included. */
const marks = signal<{ id: string; revision: number; ranges: Schemas["FrameRange"][] } | null>(null);

/** Mark what an edit replaced, in the revision that it made. */
export function markReplaced(id: string, { revision, replaced }: Schemas["FramesEdited"]): void {
  const ranges = replaced.flatMap((one) => one.ranges);
  marks.value = ranges.length ? { id, revision, ranges } : null;
}

const marksOf = (clip: Clip): Schemas["FrameRange"][] => {
  const found = marks.value;
  return found?.id === clip.id && found.revision === clip.detail.revision ? found.ranges : [];
};

/** bottom: of the ruler, px. */
export function drawReplaced(
  pen: CanvasRenderingContext2D,
  clip: Clip,
  range: Range,
  width: number,
  bottom: number,
): void {
  pen.fillStyle = colour("warn");
  for (const { first, last } of marksOf(clip)) {
    const from = toX(first - 1, range, width);
    pen.fillRect(from, bottom - TALL, Math.max(NARROWEST, toX(last, range, width) - from), TALL);
  }
}

/** The name of the marks, which hides them. */
export function ReplacedName({ clip }: { clip: Clip }) {
  const count = marksOf(clip).length;
  if (!count) return null;
  return (
    <button
      type="button"
      class="replaced-name"
      title={w("help.replacedMarks", { n: count })}
      aria-label={w("button.hideReplaced")}
      onClick={() => (marks.value = null)}
    >
      {w("label.replacedLane")}
      <Icon name="close" />
    </button>
  );
}
