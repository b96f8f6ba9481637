import { numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { bind, facingOf, fitted, follow, seenFrom, surfaceOf } from "./faces";

/** A bulged plate of markers, 11 by 11, looking along +Z with Y up; turned so that `axes` are its right, up, out. */
function face(
  axes = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
): Float32Array {
  const found: number[] = [];
  for (let row = -5; row <= 5; row++)
    for (let column = -5; column <= 5; column++) {
      const own = [column * 14, row * 20, 60 - column * column * 2 - row * row];
      found.push(
        ...[0, 1, 2].map((axis) =>
          axes.reduce((sum, one, place) => sum + numberAt(one, axis) * numberAt(own, place), 0),
        ),
      );
    }
  return Float32Array.from(found);
}

const close = (one: number[], other: number[]) =>
  one.forEach((value, at) => expect(value).toBeCloseTo(numberAt(other, at), 1));

describe("faces of markers", () => {
  it("are seen from where they bulge, upright", () => {
    close(facingOf(face(), "Y").out, [0, 0, 1]);
    close(facingOf(face(), "Y").right, [1, 0, 0]);
    close(
      facingOf(
        face([
          [-1, 0, 0],
          [0, 1, 0],
          [0, 0, -1],
        ]),
        "Y",
      ).out,
      [0, 0, -1],
    );
    close(
      facingOf(
        face([
          [0, 1, 0],
          [0, 0, 1],
          [1, 0, 0],
        ]),
        "Z",
      ).out,
      [1, 0, 0],
    );
  });

  it("have a surface that faces the eye and leaves none of them out", () => {
    const markers = face();
    const facing = facingOf(markers, "Y");
    const triangles = surfaceOf(facing, markers);
    expect(new Set(triangles).size).toBe(121);
    const places = seenFrom(facing, markers);
    for (let at = 0; at < triangles.length; at += 3) {
      const corner = (place: number, axis: number) => numberAt(places, numberAt(triangles, at + place) * 2 + axis);
      const [ax, ay] = [corner(0, 0), corner(0, 1)];
      expect((corner(1, 0) - ax) * (corner(2, 1) - ay) - (corner(1, 1) - ay) * (corner(2, 0) - ax)).toBeGreaterThan(0);
    }
    const gone = markers.slice();
    gone[33] = gone[34] = gone[35] = NaN;
    expect(surfaceOf(facing, gone)).not.toContain(11);
  });

  it("carry a mesh: where a marker is, it goes as the marker goes", () => {
    const markers = face();
    const mesh = Float32Array.from([...markers.subarray(0, 3), ...markers.subarray(150, 153)]);
    const bound = bind(mesh, markers);
    const moved = markers.slice();
    moved[0] = numberAt(moved, 0) + 5;
    moved[151] = numberAt(moved, 151) - 3;
    const now = new Float32Array(6);
    follow(bound, markers, moved, now);
    expect(now[0]).toBeCloseTo(numberAt(mesh, 0) + 5, 3);
    expect(now[4]).toBeCloseTo(numberAt(mesh, 4) - 3, 3);
    const shifted = markers.map((value, at) => (at % 3 === 1 ? value + 7 : value));
    follow(bound, markers, shifted, now);
    expect([...now]).toEqual(
      [...mesh].map((value, at) => expect.closeTo(at % 3 === 1 ? value + 7 : value, 3) as never),
    );
  });

  it("have meshes of any size put where they are", () => {
    const markers = face([
      [0, 1, 0],
      [0, 0, 1],
      [1, 0, 0],
    ]);
    const small = face().map((value) => value / 1000 + 3);
    const put = fitted(small, markers, facingOf(markers, "Z"));
    put.forEach((value, at) => expect(value).toBeCloseTo(numberAt(markers, at), 1));
  });
});
