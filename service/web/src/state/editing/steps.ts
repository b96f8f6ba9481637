/** A value with an undo history. Values are never written over: a step back is the value of before. */
import { computed, signal, type ReadonlySignal } from "@preact/signals";

export class Steps<T> {
  private readonly value;
  private readonly past = signal<readonly T[]>([]);
  private readonly future = signal<readonly T[]>([]);
  private kind = "";
  readonly now: ReadonlySignal<T>;
  readonly canUndo = computed(() => this.past.value.length > 0);
  readonly canRedo = computed(() => this.future.value.length > 0);

  /** before: what undo leads to from the very first. */
  constructor(first: T, before: readonly T[] = []) {
    this.value = signal(first);
    this.now = this.value;
    this.past.value = before;
  }

  /** One step. Steps of one kind that follow one another, as letters of a name, are one. */
  set(next: T, kind = ""): void {
    if (next === this.value.peek()) return;
    if (!kind || kind !== this.kind) this.past.value = [...this.past.peek(), this.value.peek()];
    this.kind = kind;
    this.future.value = [];
    this.value.value = next;
  }

  /** What was learnt of the value, and is no step. */
  amend(next: T): void {
    this.value.value = next;
  }

  undo(): void {
    this.go(this.past, this.future);
  }

  redo(): void {
    this.go(this.future, this.past);
  }

  private go(from: typeof this.past, to: typeof this.past): void {
    const next = from.peek().at(-1);
    if (next === undefined) return;
    from.value = from.peek().slice(0, -1);
    to.value = [...to.peek(), this.value.peek()];
    this.kind = "";
    this.value.value = next;
  }
}
