import { itemAt } from "../../lists";
import { afterEach, describe, expect, it, vi } from "vitest";
import { changedFrames, changedParts, readWindow } from "./lines";

const FRAMES = `<frame id="7">
  <frame_bone name="Root" Tx="1"/>
  <frame_bone name="left_leg" Rx="2"/>
</frame>
<frame id="8"/>
<frame id="9"><frame_bone name="Root" Tx="3"/></frame >
`;

describe("frames whose text was changed", () => {
  it("are told alone, with their address and line", () => {
    expect(changedFrames(FRAMES, FRAMES, 7)).toMatchObject([]);
    const after = FRAMES.replace('Tx="3"', 'Tx="4"').replace('<frame id="8"/>', '<frame id="8"></frame>');
    expect(changedFrames(FRAMES, after, 7)).toMatchObject([
      { address: "/mcml/motion/frame[8]", fragment: '<frame id="8"></frame>', line: 5 },
      {
        address: "/mcml/motion/frame[9]",
        fragment: '<frame id="9"><frame_bone name="Root" Tx="4"/></frame >',
        line: 6,
      },
    ]);
  });

  it("do not lose their bones to an element whose name only begins alike", () => {
    const after = FRAMES.replace('Rx="2"', 'Rx="5"');
    const [only, ...more] = changedFrames(FRAMES, after, 1);
    expect(more).toMatchObject([]);
    expect(only!.address).toBe("/mcml/motion/frame[1]");
    expect(only!.fragment).toBe(after.slice(0, after.indexOf("</frame>") + 8));
  });

  it("are refused where some were added or taken away", () => {
    expect(() => changedFrames(FRAMES, FRAMES.replace('<frame id="8"/>', ""), 7)).toThrow(RangeError);
    expect(() => changedFrames(FRAMES, `${FRAMES}<frame id="10"/>`, 7)).toThrow(RangeError);
  });

  it("are refused where something between them was changed: it would be lost in silence", () => {
    for (const more of ["<wrong/>", "words", "<!-- why -->", "</frame>"]) {
      expect(() => changedFrames(FRAMES, FRAMES.replace('<frame id="8"/>', `${more}<frame id="8"/>`), 7)).toThrow(
        RangeError,
      );
    }
    expect(() => changedFrames(FRAMES, FRAMES.replace('<frame id="8"/>', '<!-- <frame id="8"/> -->'), 7)).toThrow(
      RangeError,
    );
    expect(changedFrames(FRAMES, FRAMES.replace('<frame id="8"/>', '\n\n  <frame id="8"/>\n'), 7)).toMatchObject([]);
  });

  it("hold whatever is written between them and in their values", () => {
    const text = '<frame id="1"><frame_bone name="a>b" Tx="1"/></frame>';
    expect(itemAt(changedFrames(text, text.replace('"1"/>', '"2"/>'), 1), 0).fragment).toBe(
      '<frame id="1"><frame_bone name="a>b" Tx="2"/></frame>',
    );
    const commented = `<!-- <frame id="0"/> -->\n${text}`;
    expect(itemAt(changedFrames(commented, commented.replace('"1"/>', '"2"/>'), 1), 0).address).toBe(
      "/mcml/motion/frame[1]",
    );
    const odd = '<frame id="a>b"><frame_bone name="x" Tx="1"/></frame>';
    expect(changedFrames(odd, odd.replace('"1"/>', '"2"/>'), 1)).toMatchObject([
      { address: "/mcml/motion/frame[1]", fragment: odd.replace('"1"/>', '"2"/>'), line: 1 },
    ]);
  });
});

describe("parts of the head whose text was changed", () => {
  const HEAD = `<mcml>
  <header>
    <filename>a.bvh</filename>
  </header>
  <root/>
  <skeleton>
    <bone name="Root"><bone name="leg"/></bone>
  </skeleton>
  <motion>
`;
  it("are told alone", () => {
    expect(changedParts(HEAD, HEAD)).toMatchObject([]);
    expect(changedParts(HEAD, HEAD.replace('"leg"', '"arm"'))).toMatchObject([
      {
        address: "/mcml/skeleton",
        fragment: '<skeleton>\n    <bone name="Root"><bone name="arm"/></bone>\n  </skeleton>',
        line: 6,
      },
    ]);
    for (const [part, other] of [
      ["<mcml>", '<mcml version="2">'],
      ["<root/>", ""],
      ["<root/>", "<root/>x"],
      ["<motion>", '<motion unit="cm">'],
    ]) {
      expect(() => changedParts(HEAD, HEAD.replace(part!, other!)), other).toThrow(RangeError);
    }
    const both = HEAD.replace("a.bvh", "b.bvh").replace("<root/>", '<root name="x"/>');
    expect(changedParts(HEAD, both).map(({ address }) => address)).toMatchObject(["/mcml/header", "/mcml/root"]);
  });
});

describe("a window of text", () => {
  afterEach(() => vi.unstubAllGlobals());

  it("is asked for by frames, and says which lines it is", async () => {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (url: string) => {
      asked.push(url);
      return new Response("text", { headers: { "x-mcml-first-line": "12", "x-mcml-total-lines": "900" } });
    });
    const stop = new AbortController().signal;
    expect(await readWindow("u", 3, [5, 9], stop)).toEqual({
      text: "text",
      firstLine: 12,
      totalLines: 900,
      frames: [5, 9],
    });
    expect((await readWindow("u", 3, null, stop)).frames).toBeNull();
    expect(asked).toMatchObject([
      "/api/v1/documents/u/mcml?part=frames&first=5&last=9&revision=3&pretty=true",
      "/api/v1/documents/u/mcml?part=head&revision=3&pretty=true",
    ]);
  });
});
