import { expect, test } from "vitest";
import { arrowsOf, outlinesOf, quantitiesOf } from "./forces";

test("an arrow stands at the centre of pressure and has a metre for 1,000 N, in the unit and from the origin of the clip", () => {
  const numbers = [100, -50, 700, 0.2, 0.1, 0];
  expect([...arrowsOf(numbers, [50, 0, 1000], 0.001)]).toEqual([150, 100, -1000, 250, 50, -300]);
  const metres = [...arrowsOf(numbers, [0.05, 0, 1], 1)];
  [0.15, 0.1, -1, 0.25, 0.05, -0.3].forEach((value, at) => expect(metres[at]).toBeCloseTo(value, 6));
});

test("a force or a centre of pressure that is unknown has no arrow", () => {
  const known = [0, 0, 500, 1, 2, 0];
  for (let gone = 0; gone < 6; gone++) {
    const unknown = known.map((value, at) => (at === gone ? NaN : value));
    expect([...arrowsOf([...unknown, ...known], [0, 0, 0], 1)], `${gone}`).toEqual([1, 2, 0, 1, 2, 0.5]);
  }
  expect(arrowsOf([], [0, 0, 0], 1)).toHaveLength(0);
});

test("plates are outlined from the origin of the clip", () => {
  const corners = [
    [3, 2, 0],
    [3, -2, 0],
    [-3, -2, 0],
    [-3, 2, 0],
  ];
  const sides = [...outlinesOf({ plates: [{ name: null, corners }], origin: [1, 0, 5] })];
  expect(sides).toEqual([2, 2, -5, 2, -2, -5, 2, -2, -5, -4, -2, -5, -4, -2, -5, -4, 2, -5, -4, 2, -5, 2, 2, -5]);
  expect(outlinesOf({ plates: [], origin: [0, 0, 0] })).toHaveLength(0);
});

test("quantities stand in the order in which arrows read them", () => {
  expect(quantitiesOf("2")).toEqual(["force:2,x", "force:2,y", "force:2,z", "cop:2,x", "cop:2,y", "cop:2,z"]);
});
