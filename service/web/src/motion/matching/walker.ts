/** A body on the ground that plays rows of a library: the same rules as the server's (`following.py`). */
import { itemAt, numberAt } from "../../lists";
import { turn, WAY, WIDTH, type Library, type Point } from "./library";

/** What a body wants at the times ahead: places and directions (radians) on the ground. */
export interface Wish {
  places: Point[];
  directions: number[];
}

/** Rows first to last of the library, turned by an angle about the origin of the ground, then shifted. */
export interface Run {
  first: number;
  last: number;
  angle: number;
  shift: Point;
}

export const SEARCH_EVERY = 6;
const SHORTEST = 9;
const MEMORY = 30;
const SAME = 6;
const BETTER = 0.95;

export class Walker {
  /** Runs that have ended. */
  readonly ended: Run[] = [];
  row = -1;
  place: Point;
  private now: Run = { first: 0, last: 0, angle: 0, shift: [0, 0] };
  private since = 0;
  private played: number[] = [];

  /** steering: radians by which a cut may turn the body. */
  constructor(
    private readonly library: Library,
    place: Point,
    public facing: number,
    private readonly steering: number,
  ) {
    this.place = place;
  }

  /** Where the body is placed now. */
  get run(): Readonly<Run> {
    return this.now;
  }

  /** All runs, with the one that is played. */
  get runs(): Run[] {
    return this.now.first <= this.row ? [...this.ended, { ...this.now, last: this.row }] : this.ended;
  }

  get atEnd(): boolean {
    return this.row >= itemAt(this.library.facts.clips, this.library.clipOf(this.row)).last;
  }

  /** Metres a second. */
  get speed(): number {
    return Math.hypot(this.library.plain(this.row, 24), this.library.plain(this.row, 25));
  }

  begin(wish: Wish): void {
    this.cut(this.library.nearestWay(this.way(wish)), wish);
    this.now.first = this.row;
    this.played.push(this.row);
  }

  /** Go on, or cut to the row that continues better. True where it cut. */
  choose(wish: Wish): boolean {
    const { library } = this;
    const forced = this.atEnd;
    if (!forced && this.since < SHORTEST) return false;
    const query = new Float64Array(WIDTH);
    for (let column = WAY; column < WIDTH; column++) query[column] = library.feature(this.row, column) || 0;
    query.set(this.way(wish));
    const [row, distance] = library.nearest(query, new Set(this.played));
    if (!forced) {
      let goingOn = 0;
      for (let column = 0; column < WIDTH; column++)
        goingOn += (library.feature(this.row, column) - numberAt(query, column)) ** 2;
      const same = library.clipOf(row) === library.clipOf(this.row) && Math.abs(row - this.row) <= SAME;
      if (same || !(distance < BETTER * (library.knows(this.row) ? Math.sqrt(goingOn) : Infinity))) return false;
    }
    this.cut(row, wish);
    return true;
  }

  advance(): void {
    this.row++;
    this.since++;
    this.played.push(this.row);
    if (this.played.length > MEMORY) this.played.shift();
    const { angle, shift } = this.now;
    this.facing = angle + this.library.facing(this.row);
    const [x, y] = turn(this.library.place(this.row), angle);
    this.place = [x + shift[0], y + shift[1]];
  }

  private way({ places, directions }: Wish): Float64Array {
    const { scales } = this.library.facts;
    const way = new Float64Array(WAY);
    places.forEach((place, at) => way.set(this.seen(place), at * 2));
    directions.forEach((one, at) => way.set([Math.cos(one - this.facing), Math.sin(one - this.facing)], 6 + at * 2));
    return way.map((value, column) => value * numberAt(scales, column));
  }

  /** A place on the ground as the body sees it. */
  private seen([x, y]: Point): Point {
    return turn([x - this.place[0], y - this.place[1]], -this.facing);
  }

  private cut(row: number, wish: Wish): void {
    const { library } = this;
    if (this.row >= 0) this.ended.push({ ...this.now, last: this.row });
    // The turn about the body that brings the ways ahead nearest to each other.
    let [across, along] = [0, 0];
    const add = (x: number, y: number, [toX, toY]: Point) => {
      across += x * toY - y * toX;
      along += x * toX + y * toY;
    };
    for (let at = 0; at < 3; at++) {
      add(library.plain(row, at * 2), library.plain(row, at * 2 + 1), this.seen(itemAt(wish.places, at)));
      const direction = itemAt(wish.directions, at) - this.facing;
      add(library.plain(row, 6 + at * 2), library.plain(row, 7 + at * 2), [Math.cos(direction), Math.sin(direction)]);
    }
    this.facing += Math.max(-this.steering, Math.min(this.steering, Math.atan2(across, along)));
    const angle = this.facing - library.facing(row);
    const [x, y] = turn(library.place(row), angle);
    this.now = { first: row + 1, last: row, angle, shift: [this.place[0] - x, this.place[1] - y] };
    this.row = row;
    this.since = 0;
  }
}
