/** Points in a plane found by their place: cells of a grid, for what is under a pointer among 100,000. */
import { numberAt } from "../../lists";

export class Grid {
  private readonly cells: Int32Array; // (cells + 1): where each begins in `order`
  private readonly order: Int32Array;
  private readonly size: number;
  private readonly columns: number;
  private readonly rows: number;
  private readonly left: number;
  private readonly low: number;

  /** places: (n, 2). About two points a cell. */
  constructor(private readonly places: Float32Array) {
    const count = places.length / 2;
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (let at = 0; at < count; at++) {
      left = Math.min(left, numberAt(places, at * 2));
      right = Math.max(right, numberAt(places, at * 2));
      low = Math.min(low, numberAt(places, at * 2 + 1));
      high = Math.max(high, numberAt(places, at * 2 + 1));
    }
    [this.left, this.low] = [count ? left : 0, count ? low : 0];
    const [wide, tall] = [right - left || 1, high - low || 1];
    this.size = Math.sqrt((wide * tall * 2) / Math.max(1, count)) || 1;
    this.columns = Math.min(2048, Math.max(1, Math.ceil(wide / this.size)));
    this.rows = Math.min(2048, Math.max(1, Math.ceil(tall / this.size)));
    this.size = Math.max(wide / this.columns, tall / this.rows) * (1 + 1e-6);
    const owner = new Int32Array(count);
    this.cells = new Int32Array(this.columns * this.rows + 1);
    for (let at = 0; at < count; at++) {
      owner[at] = this.row(numberAt(places, at * 2 + 1)) * this.columns + this.column(numberAt(places, at * 2));
      this.cells[numberAt(owner, at) + 1] = numberAt(this.cells, numberAt(owner, at) + 1) + 1;
    }
    for (let cell = 0; cell < this.cells.length - 1; cell++)
      this.cells[cell + 1] = numberAt(this.cells, cell + 1) + numberAt(this.cells, cell);
    const next = this.cells.slice();
    this.order = new Int32Array(count);
    for (let at = 0; at < count; at++) {
      const cell = numberAt(owner, at);
      const place = numberAt(next, cell);
      this.order[place] = at;
      next[cell] = place + 1;
    }
  }

  private column = (x: number): number =>
    Math.max(0, Math.min(this.columns - 1, Math.floor((x - this.left) / this.size)));
  private row = (y: number): number => Math.max(0, Math.min(this.rows - 1, Math.floor((y - this.low) / this.size)));

  /** The point nearest to a place, no farther than `within`; -1 where none is. */
  nearest(x: number, y: number, within: number): number {
    let [best, least] = [-1, within * within];
    for (let row = this.row(y - within); row <= this.row(y + within); row++) {
      for (let column = this.column(x - within); column <= this.column(x + within); column++) {
        const cell = row * this.columns + column;
        for (let place = numberAt(this.cells, cell); place < numberAt(this.cells, cell + 1); place++) {
          const point = numberAt(this.order, place);
          const away = (numberAt(this.places, point * 2) - x) ** 2 + (numberAt(this.places, point * 2 + 1) - y) ** 2;
          if (away <= least) [best, least] = [point, away];
        }
      }
    }
    return best;
  }
}
