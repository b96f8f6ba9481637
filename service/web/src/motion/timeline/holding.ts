/** Edits that let one frame stand for some more. Each doubles what is there, so that a long hold is few edits. */
export interface Insertion {
  do: "insert";
  first: number;
  last: number;
  at: number;
}

/** frame: from 1. more: how many copies of it come behind it. */
export function holding(frame: number, more: number): Insertion[] {
  const edits: Insertion[] = [];
  for (let there = 1; there <= more;) {
    const copies = Math.min(there, more + 1 - there);
    edits.push({ do: "insert", first: frame, last: frame + copies - 1, at: frame + there });
    there += copies;
  }
  return edits;
}
