/** What leads a body: a path on the ground, or a direction that keys or a game pad give. */
import { itemAt, numberAt } from "../../lists";
import type { Point } from "./library";
import type { Wish } from "./walker";

const SPACING = 0.02;
const CORNER = 0.25;
const LOOK = 2;
const AHEAD = [1 / 3, 2 / 3, 1];
/** Seconds in which a body takes most of a new speed and direction. */
const HABIT = 0.3;

/** A path through points, evenly spaced, with rounded corners: the same as the server's (`paths.py`). */
export class Path {
  readonly places: Point[];
  readonly directions: number[];
  readonly ways: number[];

  constructor(points: readonly Point[]) {
    const kept = points.filter((point, at) => !at || distance(point, itemAt(points, at - 1)) > 0);
    if (kept.length < 2) throw new RangeError("a path needs two places");
    const ends = [0];
    for (let at = 1; at < kept.length; at++)
      ends.push(numberAt(ends, at - 1) + distance(itemAt(kept, at), itemAt(kept, at - 1)));
    const length = lastOf(ends);
    const count = Math.max(2, roundEven(length / SPACING) + 1);
    const even = Array.from({ length: count }, (_, at) => (length * at) / (count - 1));
    const places = even.map((way): Point => [0, 1].map((axis) => along(way, ends, kept, axis)) as unknown as Point);
    this.places = rounded(places, Math.round(CORNER / SPACING));
    const steps = this.places
      .slice(1)
      .map(([x, y], at): Point => [x - itemAt(this.places, at)[0], y - itemAt(this.places, at)[1]]);
    this.ways = [0];
    for (const [x, y] of steps) this.ways.push(lastOf(this.ways) + Math.hypot(x, y));
    this.directions = [];
    for (const [x, y] of steps) {
      const next = Math.atan2(y, x);
      const before = this.directions.at(-1) ?? next;
      this.directions.push(next + 2 * Math.PI * Math.round((before - next) / (2 * Math.PI)));
    }
    this.directions.push(lastOf(this.directions));
  }

  get length(): number {
    return lastOf(this.ways);
  }

  at(way: number): [Point, number] {
    const place = [0, 1].map((axis) => along(way, this.ways, this.places, axis)) as unknown as Point;
    return [place, interpolate(way, this.ways, this.directions)];
  }

  /** The way to the place of the path that is nearest, not before `way`, and the distance to it. */
  progress(place: Point, way: number): [number, number] {
    let [best, least] = [way, Infinity];
    for (let at = Math.min(this.first(way), this.ways.length - 1); at < this.ways.length; at++) {
      if (numberAt(this.ways, at) > way + LOOK && least < Infinity) break;
      const apart = distance(itemAt(this.places, at), place);
      if (apart < least) [best, least] = [numberAt(this.ways, at), apart];
    }
    return [Math.max(way, best), least];
  }

  /** Go on along it from a way, at a speed in metres a second. */
  wish(way: number, speed: number): Wish {
    const ahead = AHEAD.map((seconds) => this.at(way + speed * seconds));
    return { places: ahead.map(([place]) => place), directions: ahead.map(([, direction]) => direction) };
  }

  private first(way: number): number {
    let [low, high] = [0, this.ways.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (numberAt(this.ways, middle) < way) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

/** Walk with a velocity (metres a second on the ground) and turn to where it leads; [0, 0]: stop. velocity: the present
 * one. Speed and direction change as a body changes them: the differences decay exponentially. */
export function steered(place: Point, facing: number, velocity: Point, wanted: Point): Wish {
  const moves = Math.hypot(...wanted) > 0.05;
  const course = Math.atan2(wanted[1], wanted[0]);
  const turned = moves ? Math.atan2(Math.sin(course - facing), Math.cos(course - facing)) : 0;
  return {
    places: AHEAD.map((seconds) => {
      const habit = HABIT * (1 - Math.exp(-seconds / HABIT));
      return [0, 1].map(
        (axis) =>
          numberAt(place, axis) +
          numberAt(wanted, axis) * seconds +
          (numberAt(velocity, axis) - numberAt(wanted, axis)) * habit,
      ) as unknown as Point;
    }),
    directions: AHEAD.map((seconds) => facing + turned * (1 - Math.exp(-seconds / HABIT))),
  };
}

const lastOf = <T>(list: readonly T[]): T => itemAt(list, list.length - 1);

const distance = (one: Point, two: Point): number => Math.hypot(one[0] - two[0], one[1] - two[1]);

/** Halves go to the even neighbour, as in Python. */
function roundEven(value: number): number {
  const near = Math.round(value);
  return Math.abs(value % 1) === 0.5 && near % 2 ? near - 1 : near;
}

const along = (way: number, ways: readonly number[], places: readonly Point[], axis: number): number =>
  interpolate(
    way,
    ways,
    places.map((place) => numberAt(place, axis)),
  );

function interpolate(way: number, ways: readonly number[], values: readonly number[]): number {
  if (way <= numberAt(ways, 0)) return numberAt(values, 0);
  let [low, high] = [0, ways.length - 1];
  if (way >= numberAt(ways, high)) return numberAt(values, high);
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (numberAt(ways, middle) <= way) low = middle;
    else high = middle;
  }
  const [start, end] = [numberAt(ways, low), numberAt(ways, high)];
  const [from, to] = [numberAt(values, low), numberAt(values, high)];
  return from + ((way - start) / (end - start)) * (to - from);
}

/** Means over windows around each place, smaller ones near the ends, which stay. */
function rounded(places: readonly Point[], window: number): Point[] {
  if (window < 1 || places.length < 3) return [...places];
  const sums: Point[] = [[0, 0]];
  for (const [x, y] of places) sums.push([lastOf(sums)[0] + x, lastOf(sums)[1] + y]);
  return places.map((_, at) => {
    const half = Math.min(at, places.length - 1 - at, window);
    const [low, high] = [itemAt(sums, at - half), itemAt(sums, at + half + 1)];
    return [(high[0] - low[0]) / (2 * half + 1), (high[1] - low[1]) / (2 * half + 1)];
  });
}
