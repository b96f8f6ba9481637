// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { random, type Random } from "../../testing/random";
import {
  EMPTY,
  asChanges,
  frozen,
  isEmpty,
  revived,
  touched,
  withElement,
  withLabels,
  withSamples,
  type Draft,
} from "./draft";

function drawn(draw: Random): Draft {
  let draft = EMPTY;
  for (let step = draw.whole(0, 8); step > 0; step--) {
    const kind = draw.whole(0, 3);
    if (kind < 2) {
      const samples = Array.from({ length: draw.whole(1, 6) }, (): [number, number] => [
        draw.whole(1, 12),
        (draw() - 0.5) * 1e3,
      ]);
      draft = withSamples(draft, `bone_${draw.whole(1, 3)}.R${"xyz"[draw.whole(0, 2)]}`, samples);
    } else if (kind === 2) {
      draft = withLabels(draft, [{ id: -draw.whole(1, 5), name: "걷기", first: 1, last: draw.whole(1, 9) }]);
    } else {
      const address = `/mcml/header/property[${draw.whole(1, 3)}]`;
      draft = withElement(
        draft,
        draw() < 0.3
          ? { address, attributes: {}, fragment: "<property/>" }
          : {
              address,
              attributes: { [`a${draw.whole(1, 2)}`]: draw() < 0.3 ? null : '<&"' },
              ...(draw() < 0.5 ? { text: "t" } : {}),
            },
      );
    }
  }
  return draft;
}

describe("a draft", () => {
  it("is sent as blocks that say every sample once, and no other", () => {
    for (let seed = 0; seed < 200; seed++) {
      const draft = drawn(random(seed));
      const said = new Map<string, number>();
      for (const { first, columns, values } of asChanges(draft).frames ?? []) {
        for (const [row, line] of (values ?? []).entries()) {
          line.forEach((value, column) => {
            const place = `${columns[column]} ${first + row}`;
            expect(said.has(place)).toBe(false);
            said.set(place, value!);
          });
        }
      }
      const wanted = [...draft.samples].flatMap(([track, samples]) =>
        [...samples].map(([frame, value]): [string, number] => [`${track} ${frame}`, value]),
      );
      expect(said).toEqual(new Map(wanted));
    }
  });

  it("sends runs of frames as one block", () => {
    const draft = withSamples(EMPTY, "Root.Tx", [
      [7, 1],
      [6, 2],
      [8, 3],
      [10, 4],
    ]);
    expect(asChanges(draft).frames).toEqual([
      { first: 6, columns: ["Root.Tx"], values: [[2], [1], [3]] },
      { first: 10, columns: ["Root.Tx"], values: [[4]] },
    ]);
  });

  it("sends elements and labels as they shall be, and leaves what was not touched", () => {
    const draft = withElement(withElement(EMPTY, { address: "/mcml/a", attributes: { x: "1", y: "2" } }), {
      address: "/mcml/a",
      attributes: { x: null },
      text: "t",
    });
    expect(asChanges(draft, "why")).toEqual({
      frames: [],
      labels: null,
      message: "why",
      many: false,
      renumber: true,
      elements: [{ do: "change", xpath: "/mcml/a", attributes: { x: null, y: "2" }, text: "t" }],
    });
    expect(asChanges(withElement(EMPTY, { address: "/mcml/a", attributes: {}, fragment: "<a/>" })).elements).toEqual([
      { do: "replace", xpath: "/mcml/a", fragment: "<a/>" },
    ]);
    expect(asChanges(withLabels(EMPTY, [{ id: 3, name: "walk", first: 2, last: 5 }])).labels).toEqual([
      { name: "walk", first: 2, last: 5 },
    ]);
    expect(asChanges(withLabels(EMPTY, [])).labels).toEqual([]);
  });

  it("comes back from text as it was", () => {
    for (let seed = 0; seed < 200; seed++) {
      const draft = drawn(random(seed));
      expect(revived(frozen(draft, 7))).toEqual({ base: 7, draft });
    }
  });

  it("is never written over: the one before is still what it was", () => {
    for (let seed = 0; seed < 60; seed++) {
      const draft = drawn(random(seed));
      const before = frozen(draft, 1);
      withSamples(draft, "bone_1.Rx", [[1, 99]]);
      withElement(draft, { address: "/mcml/header/property[1]", attributes: { a1: "99" } });
      expect(frozen(draft, 1)).toBe(before);
    }
  });

  it("knows which frames it touches, and whether it is one at all", () => {
    expect(touched(EMPTY)).toBeNull();
    expect(isEmpty(EMPTY)).toBe(true);
    const draft = withSamples(withSamples(EMPTY, "a.Rx", [[5, 0]]), "b.Rx", [
      [3, 0],
      [4, 0],
    ]);
    expect(touched(draft)).toEqual([3, 5]);
    expect(isEmpty(draft)).toBe(false);
    expect(isEmpty(withLabels(EMPTY, []))).toBe(false);
  });
});
