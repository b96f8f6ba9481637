// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { EMPTY, withElement, withFragment, withSamples, without } from "./draft";
import { changedSamples } from "./lines";

const FRAME =
  '<frame id="5"><motion_name>walk</motion_name><frame_bone name="Root" Tx="1" Rx="2.5"/><frame_bone name="Spine" Rx="7"/></frame>';

describe("text of a frame", () => {
  it("whose numbers alone are others is samples", () => {
    const now = FRAME.replace('"2.5"', '"3.25"').replace('"7"', '"-1e2"');
    expect(changedSamples(FRAME, now)).toEqual(
      new Map([
        ["Root.Rx", 3.25],
        ["Spine.Rx", -100],
      ]),
    );
  });
  it.each([
    FRAME.replace("walk", "run"),
    FRAME.replace('name="Spine"', 'name="Neck"'),
    FRAME.replace(' Tx="1"', ""),
    FRAME.replace('id="5"', 'id="6"'),
    FRAME.replace('"7"', '"seven"'),
    FRAME.replace('"7"', '""'),
    FRAME.replace('<frame_bone name="Spine" Rx="7"/>', ""),
    FRAME.replace("</frame>", ""),
  ])("that is another otherwise is a text: %s", (now) => expect(changedSamples(FRAME, now)).toBeNull());
});

describe("a text in the place of a frame", () => {
  it("takes away what was changed within it, and nothing else", () => {
    let draft = withSamples(EMPTY, "Root.Rx", [
      [4, 1],
      [5, 2],
    ]);
    draft = withElement(draft, { address: "/mcml/motion/frame[5]/frame_bone[1]", attributes: { Tx: "3" } });
    draft = withElement(draft, { address: "/mcml/motion/frame[50]/frame_bone[1]", attributes: { Tx: "3" } });
    const next = withFragment(draft, "/mcml/motion/frame[5]", FRAME, 5);
    expect([...next.samples.get("Root.Rx")!]).toEqual([[4, 1]]);
    expect([...next.elements.keys()]).toEqual(["/mcml/motion/frame[50]/frame_bone[1]", "/mcml/motion/frame[5]"]);
  });
});

describe("a draft without what others changed", () => {
  it("keeps the frames that they did not touch", () => {
    const draft = withSamples(EMPTY, "Root.Rx", [
      [4, 1],
      [5, 2],
      [9, 3],
    ]);
    const next = without(draft, [{ kind: "frames", address: "Root.Rx", first: 5, last: 8 } as never]);
    expect([...next.samples.get("Root.Rx")!]).toEqual([
      [4, 1],
      [9, 3],
    ]);
  });
});
