import { itemAt, numberAt } from "../../lists";
import { describe, expect, it } from "vitest";
import { neighboursOf, shortestRoute } from "./routes";

const links = { a: [0, 1, 0, 3], b: [1, 2, 2, 4], length: [1, 1, 5, 2], bridge: [0, 0, 0, 1] };
const near = neighboursOf(6, links);

describe("ways over links", () => {
  it("lead both ways, the nearest first", () => {
    expect(itemAt(near, 0).map((one) => one.to)).toEqual([1, 2]);
    expect(near[4]).toEqual([{ to: 3, length: 2, bridge: true }]);
    expect(near[5]).toEqual([]);
  });
  it("are as short as they can be", () => {
    expect(shortestRoute(near, 0, 2)).toEqual({ way: [0, 1, 2], length: 2 });
    expect(shortestRoute(near, 2, 0)!.way).toEqual([2, 1, 0]);
    expect(shortestRoute(near, 3, 3)).toEqual({ way: [3], length: 0 });
    expect(shortestRoute(near, 0, 5)).toBeNull();
    expect(shortestRoute(near, 0, 3)).toBeNull();
  });
  it("are as short as trying all lengths of ways finds them", () => {
    let seed = 7;
    const next = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    const count = 24;
    const random = { a: [] as number[], b: [] as number[], length: [] as number[], bridge: [] as number[] };
    for (let at = 0; at < 50; at++) {
      const [one, other] = [Math.floor(next() * count), Math.floor(next() * count)];
      if (one === other) continue;
      random.a.push(one);
      random.b.push(other);
      random.length.push(next() * 10);
      random.bridge.push(0);
    }
    const far = Array.from({ length: count }, (_, at) =>
      Array.from({ length: count }, (_, to) => (at === to ? 0 : Infinity)),
    );
    random.a.forEach((one, at) => {
      const other = numberAt(random.b, at);
      itemAt(far, one)[other] = itemAt(far, other)[one] = Math.min(
        numberAt(itemAt(far, one), other),
        numberAt(random.length, at),
      );
    });
    for (let by = 0; by < count; by++)
      for (let one = 0; one < count; one++)
        for (let to = 0; to < count; to++)
          itemAt(far, one)[to] = Math.min(
            numberAt(itemAt(far, one), to),
            numberAt(itemAt(far, one), by) + numberAt(itemAt(far, by), to),
          );
    const made = neighboursOf(count, random);
    for (let one = 0; one < count; one++)
      for (let to = 0; to < count; to++) {
        const found = shortestRoute(made, one, to);
        if (Number.isFinite(itemAt(far, one)[to])) expect(found!.length).toBeCloseTo(numberAt(itemAt(far, one), to), 9);
        else expect(found).toBeNull();
      }
  });
});
