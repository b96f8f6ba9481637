import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { fromBase64 } from "../loading/thumbnail";
import { Path, steered } from "./goals";
import { Library, turn, type Facts, type Point } from "./library";
import { decay, posed, segmentsOf, velocityOf } from "./playing";
import { SEARCH_EVERY, Walker } from "./walker";

interface Cases {
  facts: Facts;
  rows: string;
  paths: Record<
    string,
    { points: [number, number][]; runs: [number, number][]; angles: number[]; places: Point[]; distances: number[] }
  >;
  decays: { values: number[]; speeds: number[]; frames: number[][] };
}
// Written by the tests in Python, where the program follows the same paths.
const { MCML_MATCHING } = process.env;
const cases = MCML_MATCHING ? (JSON.parse(readFileSync(MCML_MATCHING, "utf8")) as Cases) : null;

function libraryOf({ facts, rows }: Cases): Library {
  return new Library(facts, new Float32Array(fromBase64(rows).slice().buffer));
}

function follow(library: Library, path: Path) {
  const [place, facing] = path.at(0);
  const walker = new Walker(library, place, facing, Math.PI / 18);
  walker.begin(path.wish(0, 1.2));
  const [places, distances]: [Point[], number[]] = [[], []];
  let way = 0;
  for (let step = 0; step < 3000; step++) {
    const [on, distance] = path.progress(walker.place, way);
    way = on;
    places.push(walker.place);
    distances.push(distance);
    if (way >= path.length - 0.1) break;
    if (step % SEARCH_EVERY === 0 || walker.atEnd) walker.choose(path.wish(way, 1.2));
    walker.advance();
  }
  return { walker, places, distances };
}

describe.skipIf(!cases)("a body that follows a path", () => {
  it.each(Object.keys(cases?.paths ?? {}))("plays the rows that the program plays: %s", (name) => {
    const library = libraryOf(cases!);
    const { points, runs, angles, places, distances } = cases!.paths[name]!;
    const made = follow(library, new Path(points));
    expect(made.walker.runs.map((run) => run.first)).toEqual(runs.map(([first]) => first));
    // The server has places in double precision: the end may come a row earlier or later.
    made.walker.runs.forEach((run, at) => expect(Math.abs(run.last - runs[at]![1])).toBeLessThanOrEqual(1));
    made.walker.runs.forEach((run, at) => expect(run.angle).toBeCloseTo(angles[at]!, 1));
    made.places.slice(0, places.length).forEach((place, at) => {
      expect(place[0]).toBeCloseTo(places[at]![0], 1);
      expect(place[1]).toBeCloseTo(places[at]![1], 1);
      expect(made.distances[at]).toBeCloseTo(distances[at]!, 1);
    });
  });

  it("lets differences decay as the program does", () => {
    const { values, speeds, frames } = cases!.decays;
    frames.forEach((frame, at) =>
      frame.forEach((value, place) => expect(decay(values[place]!, speeds[place]!, at, 9)).toBeCloseTo(value, 9)),
    );
  });

  it("is stored as segments that follow each other in time, each at its place", () => {
    const library = libraryOf(cases!);
    const { walker } = follow(library, new Path([[0, 0], [5, 0]])); // prettier-ignore
    const segments = segmentsOf(library, walker.runs);
    const frames = segments.reduce((sum, one) => sum + one.last! - one.first + 1, 0);
    const rows = walker.runs.reduce((sum, one) => sum + one.last - one.first + 1, 0);
    expect(Math.abs(frames - rows * 2)).toBeLessThanOrEqual(segments.length);
    segments.forEach((segment, at) => {
      const run = walker.runs[at]!;
      const clip = library.facts.clips[library.clipOf(run.last)]!;
      expect(segment.document).toBe(clip.document);
      expect(segment.first).toBe((run.first - clip.first) * 2 + 1);
      const [x, y] = turn(library.place(run.first), (segment.place!.degrees * Math.PI) / 180);
      const [first, second] = [x + segment.place!.shift[2]! / 100, y + segment.place!.shift[0]! / 100];
      const [u, v] = turn(library.place(run.first), run.angle);
      expect(first).toBeCloseTo(u + run.shift[0], 4);
      expect(second).toBeCloseTo(v + run.shift[1], 4);
    });
  });

  it("draws the points of a clip where the body is", () => {
    const library = libraryOf(cases!);
    const clips = library.facts.clips.map((clip) => {
      const rows = clip.last - clip.first + 1;
      const values = new Float32Array(rows * 6);
      for (let row = 0; row < rows; row++) {
        const [z, x] = library.place(clip.first + row);
        values.set([x * 100, 90, z * 100, NaN, NaN, NaN], row * 6);
      }
      return { values, stride: 6, step: 2 };
    });
    const { walker, places } = follow(library, new Path([[0, 0], [5, 0]])); // prettier-ignore
    const points = posed(library, clips, walker.run, walker.row);
    expect(points[0]! / 100).toBeCloseTo(places.at(-1)![1], 3);
    expect(points[1]).toBe(90);
    expect(points[2]! / 100).toBeCloseTo(places.at(-1)![0], 3);
    expect(points[3]).toBeNaN();
    expect(Math.hypot(...velocityOf(library, walker.run, walker.row))).toBeCloseTo(0.75 * 1.7, 1);
  });
});

describe("goals", () => {
  it("lead along a path with rounded corners to its end", () => {
    const path = new Path([[0, 0], [0, 0], [3, 0], [3, 4]]); // prettier-ignore
    expect(path.length).toBeGreaterThan(6.8);
    expect(path.length).toBeLessThan(7);
    expect(path.at(99)[0]).toEqual([3, 4]);
    expect(path.progress([1, 0.5], 0)[0]).toBeCloseTo(1, 1);
    expect(path.progress([0, 0], 2)[0]).toBeGreaterThanOrEqual(2);
    expect(() => new Path([[1, 1], [1, 1]])).toThrow(RangeError); // prettier-ignore
  });

  it("bring speed and direction to what a hand wants, and stop where it wants nothing", () => {
    const turned = steered([0, 0], 0, [1, 0], [0, 1]);
    expect(turned.directions[2]).toBeGreaterThan(1.4);
    expect(turned.directions[2]).toBeLessThan(Math.PI / 2);
    expect(turned.places[2]![1]).toBeGreaterThan(0.6);
    const still = steered([2, 2], 1, [0, 0], [0, 0]);
    expect(still.places).toEqual([[2, 2], [2, 2], [2, 2]]); // prettier-ignore
    expect(still.directions).toEqual([1, 1, 1]);
  });
});
