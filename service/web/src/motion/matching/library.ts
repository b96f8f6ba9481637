/**
 * Rows of many clips in which the best continuation of a motion is found, as the server makes them
 * (docs/api/motion-matching.md): 27 scaled features, the place of the root on the ground (metres), where it faces
 * (radians), and 1 where a cut may lead.
 */
import type { Schemas } from "../../api/client";
import { itemAt, numberAt } from "../../lists";

export type Facts = Schemas["MatchingFacts"];
export type Point = readonly [number, number];

export const WIDTH = 27;
/** Features that a goal sets; the others are those of the row before. */
export const WAY = 12;
const STRIDE = 31;

export class Library {
  readonly length: number;

  constructor(
    readonly facts: Facts,
    private readonly rows: Float32Array,
  ) {
    this.length = rows.length / STRIDE;
  }

  feature(row: number, column: number): number {
    return numberAt(this.rows, row * STRIDE + column);
  }

  /** The same in metres and seconds. */
  plain(row: number, column: number): number {
    return this.feature(row, column) / numberAt(this.facts.scales, column);
  }

  place(row: number): Point {
    return [this.feature(row, WIDTH), this.feature(row, WIDTH + 1)];
  }

  facing(row: number): number {
    return this.feature(row, WIDTH + 2);
  }

  /** Whether all features of a row are known. */
  knows(row: number): boolean {
    return this.feature(row, 0) === this.feature(row, 0);
  }

  clipOf(row: number): number {
    const { clips } = this.facts;
    let [low, high] = [0, clips.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (itemAt(clips, middle).first <= row) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** The row nearest to a query (27 scaled features) to which a cut may lead, and its distance; one that is avoided only
   * where all are. */
  nearest(query: Float64Array, avoided: ReadonlySet<number>): [number, number] {
    const free = this.search(query, WIDTH, (row) => avoided.has(row));
    return free[0] < 0 ? this.search(query, WIDTH) : free;
  }

  /** The row whose way ahead (12 scaled features) is nearest: where nothing comes before. */
  nearestWay(way: Float64Array): number {
    return this.search(way, WAY)[0];
  }

  private search(query: Float64Array, width: number, without?: (row: number) => boolean): [number, number] {
    const { rows } = this;
    let [best, least] = [-1, Infinity];
    for (let row = 0; row < this.length; row++) {
      const start = row * STRIDE;
      if (!rows[start + STRIDE - 1]) continue;
      let sum = 0;
      for (let column = 0; column < width && sum < least; column++) {
        const off = numberAt(rows, start + column) - numberAt(query, column);
        sum += off * off;
      }
      if (sum < least && !without?.(row)) [best, least] = [row, sum];
    }
    return [best, Math.sqrt(least)];
  }
}

/** A place on the ground turned by an angle in radians. */
export function turn([x, y]: Point, angle: number): Point {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  return [cosine * x - sine * y, sine * x + cosine * y];
}
