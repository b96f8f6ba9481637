/** A space of expressions as the panel needs it: places, levels, links and faces, fetched once, faces as they are looked at. */
import { itemAt, numberAt } from "../../lists";
import { signal } from "@preact/signals";
import { ApiError, type Schemas } from "../../api/client";
import { partOf, arrayOf, resultOf, rowsOf, applyResult, type Result } from "../../api/results";
import { facingOf, type Facing } from "../../motion/faces/faces";
import { neighboursOf, shortestRoute, type Links, type Neighbour } from "../../motion/faces/routes";

export interface Level {
  number: number;
  candidates: Int32Array;
  links: Links;
  neighbours: Neighbour[][];
}
export interface Summary {
  method: string;
  frames: number;
  takes: number;
  markers: number;
  markers_dropped: unknown[];
  tau_mm: number;
  mean_degree: number;
  components: number[];
  bridges: number;
  r: number | null;
  stress: number | null;
  speed_mm_s: number;
  levels: number;
  warnings: { code: string; what: string }[];
}

const ROWS = 500; // of one question
const FACES = 4000; // kept, the oldest go first
export const MOST_LINKS = 6000;

export class Space {
  /** Moves with each face that came. */
  readonly arrived = signal(0);
  private readonly faces = new Map<number, Float32Array>();
  private readonly wanted = new Set<number>();
  private asking = false;
  private readonly levels = new Map<number, Level>();

  private constructor(
    readonly id: string,
    readonly name: string,
    readonly project: string,
    readonly summary: Summary,
    readonly documents: string[],
    readonly names: string[],
    readonly up: string,
    /** (n, 2), mm. */
    readonly places: Float32Array,
    readonly take: Int32Array,
    /** Position in its take, from 0. */
    readonly frame: Int32Array,
    readonly counts: number[],
    private readonly arrays: {
      candidates: Int32Array;
      first: number[];
      linkFirst: number[];
      a: Int32Array;
      b: Int32Array;
      length: Float32Array;
      bridge: Uint8Array;
    },
    readonly neutral: Float32Array,
    readonly facing: Facing,
    private readonly gaps: boolean,
    readonly tau: {
      chosen: number;
      rows: { tau: number; r: number | null; stress: number | null; stretch: number | null }[];
    },
  ) {}

  static async load(result: Result): Promise<Space> {
    const { id } = result;
    const parts = result.parts ?? {};
    const summary = partOf(result, "space").data.summary as Summary;
    const values = partOf(result, "space").data.values as {
      neutral: number;
      up: string;
      documents: string[];
      names: string[];
    };
    const whole = async (part: string, array: string, single = false) =>
      (await arrayOf(id, part, array, { single })).values;
    const [coordinates, take, frame, candidates, first, linkFirst, a, b, length, bridge, neutral] = await Promise.all([
      arrayOf(id, "map", "coordinates", { single: true }),
      whole("map", "take"),
      whole("map", "frame"),
      whole("levels", "candidates"),
      whole("levels", "first"),
      whole("links", "first"),
      whole("links", "a"),
      whole("links", "b"),
      whole("links", "length", true),
      whole("links", "bridge"),
      arrayOf(id, "space", "positions", { rows: [values.neutral], single: true }),
    ]);
    const [count = 0, columns = 0] = coordinates.shape;
    const places = new Float32Array(count * 2);
    for (let at = 0; at < count; at++) {
      places[at * 2] = numberAt(coordinates.values, at * columns);
      places[at * 2 + 1] = numberAt(coordinates.values, at * columns + 1);
    }
    const gaps = Boolean(partOf(result, "space").arrays?.missing);
    const face = await withGaps(id, gaps, [values.neutral], neutral.values as Float32Array);
    const up = values.up || "Y";
    return new Space(
      id,
      result.name,
      result.project,
      summary,
      values.documents,
      values.names,
      up,
      places,
      Int32Array.from(take),
      Int32Array.from(frame),
      rowsOf<{ candidates: number }>(parts.levels).map((one) => one.candidates),
      {
        candidates: Int32Array.from(candidates),
        first: [...first],
        linkFirst: [...linkFirst],
        a: Int32Array.from(a),
        b: Int32Array.from(b),
        length: length as Float32Array,
        bridge: bridge as Uint8Array,
      },
      face,
      facingOf(face, up),
      gaps,
      partOf(result, "tau").data as never,
    );
  }

  /** Candidates and links of a level. The finest has every frame, and links beyond drawing. */
  level(number: number): Level {
    const before = this.levels.get(number);
    if (before) return before;
    const { candidates, first, linkFirst, a, b, length, bridge } = this.arrays;
    const own = candidates.subarray(first[number], first[number + 1]);
    const [from, to] = [linkFirst[number], linkFirst[number + 1]];
    const links = {
      a: a.subarray(from, to),
      b: b.subarray(from, to),
      length: length.subarray(from, to),
      bridge: bridge.subarray(from, to),
    };
    const made = { number, candidates: own, links, neighbours: neighboursOf(own.length, links) };
    this.levels.set(number, made);
    return made;
  }

  /** Those that a candidate is linked to. Of the finest level they are asked for: it lists no links. */
  async near(level: Level, candidate: number): Promise<Neighbour[]> {
    if (level.links.a.length || itemAt(level.neighbours, candidate).length) return itemAt(level.neighbours, candidate);
    const done = await applyResult<Schemas["ExpressionNeighbours"]>(this.id, "neighbours", {
      level: level.number,
      ...this.keyOf(numberAt(level.candidates, candidate)),
    });
    return (level.neighbours[candidate] = done.value.neighbours.map((one) => ({
      to: one.id,
      length: one.length_mm,
      bridge: one.bridge,
    })));
  }

  /** The way over links from one candidate to another, as candidates; null where there is none. */
  async route(level: Level, from: number, to: number): Promise<{ way: number[]; length: number } | null> {
    if (level.links.a.length) return shortestRoute(level.neighbours, from, to);
    const keys = [from, to].map((one) => this.keyOf(numberAt(level.candidates, one)));
    try {
      await applyResult(this.id, "path", { level: level.number, keys });
      return null;
    } catch (error) {
      // The refusal says the way.
      const way =
        (error instanceof ApiError && (error.problem.details?.suggestion as { document: string; frame: number }[])) ||
        null;
      if (!way) throw error;
      const numbers = way.map((one) => level.candidates.indexOf(this.numberOf(one.document, one.frame)));
      let length = 0;
      for (let at = 1; at < numbers.length; at++)
        length +=
          (await this.near(level, numberAt(numbers, at - 1))).find((one) => one.to === numbers[at])?.length ?? 0;
      return { way: numbers, length };
    }
  }

  /** The markers of a frame, (markers, 3); null while they come. Reading it from an effect draws again when they are there. */
  face(frame: number): Float32Array | null {
    this.arrived.value;
    const found = this.faces.get(frame);
    if (!found) this.want([frame]);
    return found ?? null;
  }

  want(frames: Iterable<number>): void {
    for (const frame of frames) if (!this.faces.has(frame)) this.wanted.add(frame);
    if (!this.asking && this.wanted.size) void this.fetchFaces();
  }

  private async fetchFaces(): Promise<void> {
    this.asking = true;
    try {
      // The last that was wanted is what is looked at now.
      await Promise.resolve();
      const rows = [...this.wanted].slice(-ROWS);
      for (const row of rows) this.wanted.delete(row);
      const { values, shape } = await arrayOf(this.id, "space", "positions", { rows, single: true });
      const size = numberAt(shape, 1) * 3;
      const all = await withGaps(this.id, this.gaps, rows, values as Float32Array);
      rows.forEach((row, at) => this.faces.set(row, all.slice(at * size, (at + 1) * size)));
      while (this.faces.size > FACES) this.faces.delete(this.faces.keys().next().value!);
      this.arrived.value++;
    } finally {
      this.asking = false;
    }
    if (this.wanted.size) void this.fetchFaces();
  }

  wordsOf(frame: number): { take: string; frame: number } {
    return { take: itemAt(this.names, numberAt(this.take, frame)), frame: numberAt(this.frame, frame) + 1 };
  }

  keyOf(frame: number): { document: string; frame: number } {
    return { document: itemAt(this.documents, numberAt(this.take, frame)), frame: numberAt(this.frame, frame) + 1 };
  }

  /** The number of a frame that is named by its take; -1 where the space has none. */
  numberOf(document: string, frame: number): number {
    const take = this.documents.indexOf(document);
    for (let at = 0; at < this.take.length; at++) if (this.take[at] === take && this.frame[at] === frame - 1) return at;
    return -1;
  }
}

/** Markers that a frame has not are NaN; stored positions have zeros there. */
async function withGaps(id: string, gaps: boolean, rows: number[], values: Float32Array): Promise<Float32Array> {
  if (!gaps) return values;
  const missing = (await arrayOf(id, "space", "missing", { rows })).values;
  for (let at = 0; at < missing.length; at++) if (missing[at]) values.fill(NaN, at * 3, at * 3 + 3);
  return values;
}

/** The space that a result is, or that its path lies in; and that path's result. */
export async function openSpace(id: string): Promise<{ space: Space; path: Result | null }> {
  const result = await resultOf(id);
  let root = result;
  while (root.parameters.operation && root.parent) root = await resultOf(root.parent);
  return { space: await loaded(root), path: root.id === result.id ? null : result };
}

const kept = new Map<string, Promise<Space>>();

function loaded(root: Result): Promise<Space> {
  const before = kept.get(root.id);
  if (before) return before;
  kept.clear();
  const made = Space.load(root);
  kept.set(root.id, made);
  made.catch(() => kept.delete(root.id));
  return made;
}
