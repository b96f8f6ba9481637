/** A name that is cut in the middle where it has no room: names of clips often differ in their ends. */
const TAIL = 8;
/** What the eye takes for one letter stays whole. */
const letters = new Intl.Segmenter();

export function MiddleCut({ text }: { text: string }) {
  const parts = Array.from(letters.segment(text), (one) => one.segment);
  const at = Math.max(0, parts.length - TAIL);
  return (
    <span class="middle-cut" title={text}>
      <span>{parts.slice(0, at).join("")}</span>
      <span>{parts.slice(at).join("")}</span>
    </span>
  );
}
