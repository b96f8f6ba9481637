/**
 * The document as a tree of any size: elements are asked for in windows when they come into sight. A row becomes a node by
 * arithmetic over what is opened, so a tree of millions of rows costs what is on the screen.
 */
import { itemAt } from "../../lists";
import { signal } from "@preact/signals";
import { get } from "../../api/client";

export interface Element {
  address: string;
  name: string;
  attributes: Record<string, string>;
  text: string;
  children: number;
}

/** One row: an element, or one attribute of it, or its text beside children; null: it is on its way. */
export interface Row {
  depth: number;
  node: Element | null;
  attribute: string | null;
  /** Where it stands among its siblings, from 0, and how many there are. */
  place: number;
  siblings: number;
  open: boolean;
}

const WINDOW = 100;
/** ms after which a window that could not be had is asked for again: whoever draws rows asks for them each time. */
export const PAUSE = 3000;

class Branch {
  total: number;
  readonly items = new Map<number, Element>();
  readonly opened = new Map<number, Branch>();
  readonly asked = new Map<number, Promise<void>>();

  constructor(readonly element: Element) {
    this.total = element.children;
  }

  get attributes(): string[] {
    return Object.keys(this.element.attributes);
  }

  /** Rows below the element's own. */
  get rows(): number {
    let sum = this.attributes.length + this.total;
    for (const branch of this.opened.values()) sum += branch.rows;
    return sum;
  }

  sorted(): [number, Branch][] {
    return [...this.opened].sort((a, b) => a[0] - b[0]);
  }
}

export class Outline {
  readonly version = signal(0);
  readonly trouble = signal<unknown>(null);
  private readonly root: Branch;

  constructor(
    private readonly id: string,
    private readonly revision: number,
  ) {
    this.root = new Branch({ address: "/mcml", name: "mcml", attributes: {}, text: "", children: 0 });
    void this.fetch(this.root, 0);
  }

  /** Rows of the whole tree, the root's own first. */
  get rows(): number {
    return 1 + this.root.rows;
  }

  row(index: number): Row {
    if (index === 0) return { depth: 0, node: this.root.element, attribute: null, place: 0, siblings: 1, open: true };
    return this.find(this.root, index - 1, 1);
  }

  private find(branch: Branch, index: number, depth: number): Row {
    const attributes = branch.attributes;
    if (index < attributes.length) {
      return {
        depth,
        node: branch.element,
        attribute: itemAt(attributes, index),
        place: index,
        siblings: attributes.length + branch.total,
        open: false,
      };
    }
    let left = index - attributes.length; // rows of children, opened ones with what is below them
    let place = 0;
    for (const [at, below] of branch.sorted()) {
      const before = at - place;
      if (left < before) break;
      left -= before;
      place = at;
      if (left === 0) break;
      if (left - 1 < below.rows) return this.find(below, left - 1, depth + 1);
      left -= 1 + below.rows;
      place = at + 1;
    }
    place += left;
    return {
      depth,
      node: branch.items.get(place) ?? this.awaited(branch, place),
      attribute: null,
      place,
      siblings: branch.total,
      open: branch.opened.has(place),
    };
  }

  private awaited(branch: Branch, place: number): null {
    void this.fetch(branch, Math.floor(place / WINDOW));
    return null;
  }

  private fetch(branch: Branch, window: number): Promise<void> {
    const before = branch.asked.get(window);
    if (before) return before;
    const asking = this.load(branch, window).catch((error: unknown) => {
      this.trouble.value = error;
      setTimeout(() => {
        branch.asked.delete(window);
        this.version.value++;
      }, PAUSE);
    });
    branch.asked.set(window, asking);
    return asking;
  }

  private async load(branch: Branch, window: number): Promise<void> {
    const answer = await get("/documents/{id}/children", {
      path: { id: this.id },
      query: { address: branch.element.address, first: window * WINDOW + 1, limit: WINDOW, revision: this.revision },
    });
    this.trouble.value = null;
    branch.total = answer.total;
    answer.items.forEach((item, index) => branch.items.set(window * WINDOW + index, item));
    if (branch === this.root && window === 0) this.openFirst();
    this.version.value++;
  }

  /** Of a fresh tree the skeleton and the motion stand open. */
  private openFirst(): void {
    for (const [place, item] of this.root.items)
      if (/^(motion)$/.test(item.name)) this.root.opened.set(place, new Branch(item));
  }

  isLeaf(element: Element): boolean {
    return element.children === 0 && Object.keys(element.attributes).length === 0;
  }

  toggle(address: string, open?: boolean): void {
    const found = this.parentOf(address);
    if (!found) return;
    const [branch, place] = found;
    if (branch.opened.has(place) && open !== true) branch.opened.delete(place);
    else if (!branch.opened.has(place) && open !== false)
      branch.opened.set(place, new Branch(branch.items.get(place)!));
    this.version.value++;
  }

  private parentOf(address: string, branch = this.root): [Branch, number] | null {
    for (const [place, item] of branch.items) if (item.address === address) return [branch, place];
    for (const below of branch.opened.values()) {
      const found = this.parentOf(address, below);
      if (found) return found;
    }
    return null;
  }

  /** The row of a frame (from 1) in the motion, which is opened with that frame for it. */
  async rowOfFrame(frame: number, bone: string | null): Promise<number> {
    await this.fetch(this.root, 0);
    const motion = [...this.root.items].find(([, item]) => item.name === "motion");
    if (!motion) return -1;
    const [place, element] = motion;
    if (!this.root.opened.has(place)) this.root.opened.set(place, new Branch(element));
    const branch = this.root.opened.get(place)!;
    await this.fetch(branch, 0);
    const before = [...branch.items].sort((a, b) => a[0] - b[0]).findIndex(([, item]) => item.name === "frame");
    if (before < 0) return -1;
    const at = before + frame - 1;
    if (!branch.items.has(at)) await this.fetch(branch, Math.floor(at / WINDOW));
    const item = branch.items.get(at);
    if (!item) return -1;
    if (!branch.opened.has(at)) branch.opened.set(at, new Branch(item));
    const below = branch.opened.get(at)!;
    await this.fetch(below, 0);
    let row = 1 + this.rowsBefore(this.root, place) + 1 + this.rowsBefore(branch, at);
    if (bone !== null) {
      const inside = [...below.items].find(([, one]) => one.attributes.name === bone);
      if (inside) {
        if (!below.opened.has(inside[0])) below.opened.set(inside[0], new Branch(inside[1]));
        row += 1 + this.rowsBefore(below, inside[0]);
      }
    }
    this.version.value++;
    return row;
  }

  private rowsBefore(branch: Branch, place: number): number {
    let sum = branch.attributes.length + place;
    for (const [at, below] of branch.opened) if (at < place) sum += below.rows;
    return sum;
  }
}
