// @vitest-environment happy-dom
import { itemAt } from "../../lists";
import { describe, expect, it } from "vitest";
import {
  EMPTY,
  Replaced,
  asChanges,
  withAdded,
  withDeleted,
  withElement,
  withFragment,
  withLabels,
  withSamples,
  withoutAdded,
} from "./draft";
import { readWithin } from "./fragment";

const FRAME =
  '<frame id="5"><motion_name>walk</motion_name><frame_bone name="Root" Tx="1" Rx="2.5"/><frame_bone name="Spine" Rx="7"/></frame>';
const AT = "/mcml/motion/frame[5]";
const HEADER = '<header><property name="age" value="23"/><property name="side" value="left &amp; right"/></header>';

const sent = (draft: Parameters<typeof asChanges>[0]) =>
  asChanges(draft).elements as { do: string; xpath: string; fragment: string }[];

describe("a change of what a text of the draft has replaced", () => {
  const framed = withFragment(EMPTY, AT, FRAME, 5);

  it("goes into the text: an attribute, a text, whichever element of it", () => {
    let draft = withElement(withFragment(EMPTY, "/mcml/header", HEADER, null), {
      address: "/mcml/header/property[2]",
      attributes: { value: "both", unit: "<" },
    });
    draft = withElement(draft, { address: "/mcml/header", attributes: { format: "bvh" } });
    const [only, ...more] = sent(draft);
    expect(more).toEqual([]);
    expect(only).toMatchObject({ do: "replace", xpath: "/mcml/header" });
    expect(readWithin(only!.fragment, "property[2]", "value")).toBe("both");
    expect(readWithin(only!.fragment, "property[2]", "unit")).toBe("<");
    expect(readWithin(only!.fragment, "property", "value")).toBe("23");
    expect(readWithin(only!.fragment, "", "format")).toBe("bvh");
    const named = withElement(framed, { address: `${AT}/motion_name`, attributes: {}, text: "run" });
    expect(readWithin(itemAt(sent(named), 0).fragment, "motion_name", null)).toBe("run");
    expect(draft.steps).toBe(2);
  });

  it("goes into the text: samples of that frame, and no others", () => {
    const draft = withSamples(framed, "Spine.Rx", [
      [4, 1],
      [5, -2.25],
      [6, 3],
    ]);
    expect(readWithin(itemAt(sent(draft), 0).fragment, "frame_bone[2]", "Rx")).toBe("-2.25");
    expect([...draft.samples.get("Spine.Rx")!]).toEqual([
      [4, 1],
      [6, 3],
    ]);
    expect(withSamples(framed, "Spine.Rx", [[5, 1]]).samples.size).toBe(0);
  });

  it("goes into the text: names of stretches over that frame", () => {
    const walk = { id: 1, name: "walk", first: 1, last: 9 };
    const draft = withLabels(
      framed,
      [
        { ...walk, last: 4 },
        { id: -1, name: "turn", first: 5, last: 7 },
      ],
      [walk],
    );
    expect(itemAt(sent(draft), 0).fragment).toContain("<motion_name>turn</motion_name><frame_bone");
    expect(itemAt(sent(draft), 0).fragment).not.toContain("walk");
    expect(
      itemAt(sent(withLabels(framed, [walk, { id: -1, name: "turn", first: 6, last: 7 }], [walk])), 0).fragment,
    ).toBe(FRAME);
  });

  it("is refused where the text has no such place", () => {
    expect(() => withElement(framed, { address: `${AT}/frame_bone[3]`, attributes: { Rx: "1" } })).toThrow(Replaced);
    expect(() => withSamples(framed, "left_foot.Rx", [[5, 1]])).toThrow(Replaced);
    expect(() => withElement(withFragment(EMPTY, AT, "<frame", 5), { address: AT, attributes: { id: "1" } })).toThrow(
      Replaced,
    );
    expect(() => withAdded(framed, `${AT}/frame_bone[1]`, { where: "after", fragment: "<frame_bone/>" })).toThrow(
      Replaced,
    );
    expect(() => withElement(withDeleted(EMPTY, AT), { address: `${AT}/frame_bone`, attributes: { Rx: "1" } })).toThrow(
      Replaced,
    );
  });
});

describe("elements that come and go", () => {
  const at = "/mcml/header/property[2]";
  it("are sent so that each stands where it was put", () => {
    let draft = withElement(EMPTY, { address: at, attributes: { value: "x" } });
    for (const [where, fragment] of [
      ["before", "<a/>"],
      ["before", "<b/>"],
      ["after", "<c/>"],
      ["after", "<d/>"],
      ["into", "<e/>"],
      ["into", "<f/>"],
    ] as const)
      draft = withAdded(draft, at, { where, fragment });
    expect(sent(draft).map((one) => one.fragment ?? one.do)).toEqual([
      "change",
      "<e/>",
      "<f/>",
      "<d/>",
      "<c/>",
      "<b/>",
      "<a/>",
    ]);
    draft = withoutAdded(draft, at, 0);
    expect(sent(draft).map((one) => one.fragment ?? one.do)).toEqual([
      "change",
      "<e/>",
      "<f/>",
      "<d/>",
      "<c/>",
      "<b/>",
    ]);
    expect(withoutAdded(withAdded(EMPTY, at, { where: "after", fragment: "<a/>" }), at, 0).elements.size).toBe(0);
  });

  it("take with them what was changed within, and stay when deleted twice", () => {
    const draft = withDeleted(withElement(EMPTY, { address: `${at}/x`, attributes: { a: "1" } }), at);
    expect(sent(draft)).toEqual([{ do: "delete", xpath: at, renumber: true }]);
    expect(withDeleted(draft, at).elements.size).toBe(0);
    const beside = withDeleted(
      withAdded(withAdded(EMPTY, at, { where: "after", fragment: "<b/>" }), at, { where: "before", fragment: "<a/>" }),
      at,
    );
    expect(sent(beside)).toEqual([{ do: "replace", xpath: at, fragment: "<a/><b/>" }]);
    expect(sent(withDeleted(beside, at)).map((one) => one.fragment)).toEqual(["<b/>", "<a/>"]);
  });
});
