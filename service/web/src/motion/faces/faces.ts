/** Faces of markers: the side one looks at, a surface between the markers, and other surfaces that follow them. */
import { itemAt, numberAt } from "../../lists";
import Delaunator from "delaunator";

/** Columns x, y, z: where right, up and towards the eye are, as unit vectors. */
export interface Facing {
  right: number[];
  up: number[];
  out: number[];
}

const LONGEST = 3.2; // median edges; longer ones lead over the rim of the face
const NEAREST = 4; // markers that move a vertex

const dot = (a: ArrayLike<number>, b: ArrayLike<number>): number =>
  numberAt(a, 0) * numberAt(b, 0) + numberAt(a, 1) * numberAt(b, 1) + numberAt(a, 2) * numberAt(b, 2);
const cross = (a: number[], b: number[]): number[] => [
  numberAt(a, 1) * numberAt(b, 2) - numberAt(a, 2) * numberAt(b, 1),
  numberAt(a, 2) * numberAt(b, 0) - numberAt(a, 0) * numberAt(b, 2),
  numberAt(a, 0) * numberAt(b, 1) - numberAt(a, 1) * numberAt(b, 0),
];
const unit = (a: number[]): number[] => {
  const size = Math.hypot(...a) || 1;
  return a.map((one) => one / size);
};

/** From where a face is seen: out is where it bulges to; up is the stated axis, as far as the face stands by it. */
export function facingOf(markers: Float32Array, up: string): Facing {
  const count = markers.length / 3;
  const mean = [0, 0, 0];
  let seen = 0;
  for (let at = 0; at < count; at++) {
    if (Number.isNaN(markers[at * 3])) continue;
    seen++;
    for (let axis = 0; axis < 3; axis++) mean[axis] = numberAt(mean, axis) + numberAt(markers, at * 3 + axis);
  }
  for (let axis = 0; axis < 3; axis++) mean[axis] = numberAt(mean, axis) / (seen || 1);
  const axis = { X: 0, Y: 1, Z: 2 }[up.at(-1) ?? "Y"] ?? 1;
  const above = [0, 0, 0];
  above[axis] = up.startsWith("-") ? -1 : 1;
  // The covariance across the up axis: its smaller direction is the one through the face.
  const [p, q] = [(axis + 1) % 3, (axis + 2) % 3];
  let [pp, pq, qq] = [0, 0, 0];
  for (let at = 0; at < count; at++) {
    const [x, y] = [
      numberAt(markers, at * 3 + p) - numberAt(mean, p),
      numberAt(markers, at * 3 + q) - numberAt(mean, q),
    ];
    if (Number.isNaN(x)) continue;
    pp += x * x;
    pq += x * y;
    qq += y * y;
  }
  const angle = Math.atan2(2 * pq, pp - qq) / 2 + Math.PI / 2;
  let out = [0, 0, 0];
  out[p] = Math.cos(angle);
  out[q] = Math.sin(angle);
  // A face bulges outwards: its middle lies before its rim.
  let bulge = 0;
  const side = cross(above, out);
  for (let at = 0; at < count; at++) {
    const away = [0, 1, 2].map((one) => numberAt(markers, at * 3 + one) - numberAt(mean, one));
    if (Number.isNaN(away[0])) continue;
    bulge -= dot(away, out) * dot(away, side) ** 2;
  }
  if (bulge < 0) out = out.map((one) => -one);
  return { right: unit(cross(above, out)), up: above, out: unit(out) };
}

/** Places (n, 2) of markers as the eye sees them, y upwards. */
export function seenFrom(facing: Facing, markers: Float32Array): Float32Array {
  const found = new Float32Array((markers.length / 3) * 2);
  for (let at = 0; at < markers.length / 3; at++) {
    const one = markers.subarray(at * 3, at * 3 + 3);
    found[at * 2] = dot(one, facing.right);
    found[at * 2 + 1] = dot(one, facing.up);
  }
  return found;
}

/** Triangles between markers: Delaunay's of the neutral face as it is seen, without those over the rim. */
export function surfaceOf(facing: Facing, neutral: Float32Array): Uint32Array {
  const places = seenFrom(facing, neutral);
  const there = Array.from({ length: neutral.length / 3 }, (_, at) => at).filter(
    (at) => !Number.isNaN(neutral[at * 3]),
  );
  if (there.length < 3) return new Uint32Array(0);
  const { triangles } = new Delaunator(Float64Array.from(there.flatMap((at) => [places[at * 2], places[at * 2 + 1]])));
  const long = (a: number, b: number) =>
    Math.hypot(...[0, 1, 2].map((axis) => numberAt(neutral, a * 3 + axis) - numberAt(neutral, b * 3 + axis)));
  const found: { corners: number[]; longest: number }[] = [];
  for (let at = 0; at < triangles.length; at += 3) {
    const corner = (place: number) => numberAt(there, numberAt(triangles, at + place));
    const [a, b, c] = [corner(0), corner(1), corner(2)];
    found.push({
      corners: [a, b, c],
      longest: Math.max(long(a, b), long(b, c), long(c, a)),
    });
  }
  const sorted = found.map((one) => one.longest).sort((one, other) => one - other);
  const limit = LONGEST * (sorted[sorted.length >> 1] ?? 0);
  // Delaunator turns clockwise where y grows downwards: as seen here, its triangles face the eye when turned round.
  return Uint32Array.from(found.filter((one) => one.longest <= limit).flatMap(({ corners: [a, b, c] }) => [a, c, b]));
}

/** Of each vertex of a surface the markers that move it, and how much: the nearest in the neutral face, by distance. */
export interface Binding {
  markers: Int32Array;
  weights: Float32Array;
  rest: Float32Array;
}

export function bind(vertices: Float32Array, neutral: Float32Array): Binding {
  const count = vertices.length / 3;
  const markers = new Int32Array(count * NEAREST);
  const weights = new Float32Array(count * NEAREST);
  for (let vertex = 0; vertex < count; vertex++) {
    const near: [number, number][] = [];
    for (let marker = 0; marker < neutral.length / 3; marker++) {
      if (Number.isNaN(neutral[marker * 3])) continue;
      let away = 0;
      for (let axis = 0; axis < 3; axis++)
        away += (numberAt(vertices, vertex * 3 + axis) - numberAt(neutral, marker * 3 + axis)) ** 2;
      near.push([away, marker]);
    }
    near.sort((one, other) => one[0] - other[0]);
    let total = 0;
    for (let place = 0; place < NEAREST; place++) {
      const [away, marker] = near[Math.min(place, near.length - 1)] ?? [0, 0];
      const weight = place < near.length ? 1 / (away + 1e-6) : 0;
      markers[vertex * NEAREST + place] = marker;
      weights[vertex * NEAREST + place] = weight;
      total += weight;
    }
    for (let place = 0; place < NEAREST; place++)
      weights[vertex * NEAREST + place] = numberAt(weights, vertex * NEAREST + place) / (total || 1);
  }
  return { markers, weights, rest: vertices.slice() };
}

/** The vertices of a bound surface for a face: each moved as its markers are. */
export function follow(binding: Binding, neutral: Float32Array, markers: Float32Array, into: Float32Array): void {
  for (let vertex = 0; vertex < into.length / 3; vertex++) {
    for (let axis = 0; axis < 3; axis++) {
      let moved = 0;
      for (let place = 0; place < NEAREST; place++) {
        const marker = numberAt(binding.markers, vertex * NEAREST + place);
        const step = numberAt(markers, marker * 3 + axis) - numberAt(neutral, marker * 3 + axis);
        if (step === step) moved += numberAt(binding.weights, vertex * NEAREST + place) * step;
      }
      into[vertex * 3 + axis] = numberAt(binding.rest, vertex * 3 + axis) + moved;
    }
  }
}

/** Put a mesh of any size where the neutral face is: turned to its eye, as tall as the markers, in their middle. */
export function fitted(vertices: Float32Array, neutral: Float32Array, facing: Facing): Float32Array {
  const box = (values: Float32Array, along: ArrayLike<number>): [number, number] => {
    let [least, most] = [Infinity, -Infinity];
    for (let at = 0; at < values.length; at += 3) {
      const value =
        numberAt(values, at) * numberAt(along, 0) +
        numberAt(values, at + 1) * numberAt(along, 1) +
        numberAt(values, at + 2) * numberAt(along, 2);
      if (value < least) least = value;
      if (value > most) most = value;
    }
    return [least, most];
  };
  const own = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  const to = [facing.right, facing.up, facing.out];
  const from = own.map((axis) => box(vertices, axis));
  const goal = to.map((axis) => box(neutral, axis));
  const scale = (itemAt(goal, 1)[1] - itemAt(goal, 1)[0]) / (itemAt(from, 1)[1] - itemAt(from, 1)[0] || 1);
  const found = new Float32Array(vertices.length);
  for (let at = 0; at < vertices.length; at += 3) {
    // Sides and height meet in their middles; depth by the foremost point, which is the nose of both.
    const along = own.map((_, axis) => {
      const value = numberAt(vertices, at + axis);
      return axis === 2
        ? itemAt(goal, 2)[1] + (value - itemAt(from, 2)[1]) * scale
        : (itemAt(goal, axis)[0] + itemAt(goal, axis)[1]) / 2 +
            (value - (itemAt(from, axis)[0] + itemAt(from, axis)[1]) / 2) * scale;
    });
    for (let axis = 0; axis < 3; axis++)
      found[at + axis] =
        numberAt(itemAt(to, 0), axis) * numberAt(along, 0) +
        numberAt(itemAt(to, 1), axis) * numberAt(along, 1) +
        numberAt(itemAt(to, 2), axis) * numberAt(along, 2);
  }
  return found;
}
