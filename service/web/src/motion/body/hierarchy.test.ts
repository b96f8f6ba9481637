import { itemAt, numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { tidy } from "./hierarchy";

describe("the picture of a hierarchy", () => {
  it("has parents in the middle of their children, and no two nodes in one place", () => {
    for (let seed = 0; seed < 100; seed++) {
      const draw = random(seed);
      const parents = Array.from({ length: draw.whole(1, 40) }, (_, node) =>
        node && draw() < 0.95 ? draw.whole(0, node - 1) : -1,
      );
      const { places, width, height } = tidy(parents);
      const depth = (node: number): number => (numberAt(parents, node) < 0 ? 0 : 1 + depth(numberAt(parents, node)));
      parents.forEach((parent, node) => {
        expect(itemAt(places, node).x).toBe(depth(node));
        const below = parents
          .map((_, other) => other)
          .filter((other) => parents[other] === node)
          .map((other) => itemAt(places, other).y);
        if (below.length) expect(itemAt(places, node).y).toBeCloseTo((Math.min(...below) + Math.max(...below)) / 2, 9);
        else expect(Number.isInteger(itemAt(places, node).y)).toBe(true);
        if (parent >= 0) expect(itemAt(places, node).x).toBe(itemAt(places, parent).x + 1);
      });
      expect(new Set(places.map(({ x, y }) => `${x} ${y}`)).size).toBe(parents.length);
      expect(width).toBe(Math.max(...parents.map((_, node) => depth(node))) + 1);
      expect(height).toBe(parents.filter((_, node) => !parents.includes(node)).length);
    }
  });

  it("keeps leaves in the order of the file", () => {
    const { places } = tidy([-1, 0, 1, 0, 3]);
    expect(itemAt(places, 2).y).toBeLessThan(itemAt(places, 4).y);
  });

  it("of nothing is nothing", () => expect(tidy([]).places).toEqual([]));
});
