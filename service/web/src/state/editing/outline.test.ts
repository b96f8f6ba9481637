import { itemAt } from "../../lists";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { random, type Random } from "../../testing/random";
import { Outline, PAUSE, type Element } from "./outline";

interface Node {
  name: string;
  attributes: Record<string, string>;
  children: Node[];
  address: string;
}

/** A document with frames enough for several windows. */
function drawn(draw: Random, frames: number): Node {
  const node = (name: string, attributes: Record<string, string> = {}, children: Node[] = []): Node => ({
    name,
    attributes,
    children,
    address: "",
  });
  const bones = draw.whole(0, 3);
  const frame = (id: number) =>
    node(
      "frame",
      { id: String(id) },
      Array.from({ length: bones }, (_, bone) => node("frame_bone", { name: `bone_${bone}`, Rx: "1", Ry: "2" })),
    );
  const found = node("mcml", {}, [
    node("header", {}, [node("filename")]),
    node("skeleton", { name: "s" }, [node("bone", { name: "Root" }, [node("bone", { name: "leg" })])]),
    node(
      "motion",
      draw() < 0.5 ? { unit: "cm" } : {},
      Array.from({ length: frames }, (_, index) => frame(index + 1)),
    ),
  ]);
  const name = (one: Node, address: string) => {
    one.address = address;
    one.children.forEach((child, index) =>
      name(
        child,
        `${address}/${child.name}[${one.children.slice(0, index + 1).filter((other) => other.name === child.name).length}]`,
      ),
    );
  };
  name(found, "/mcml");
  return found;
}

/** All rows of a tree in which these addresses are opened. */
function flat(node: Node, opened: Set<string>, depth = 0): string[] {
  const inside = opened.has(node.address) || depth === 0;
  const attributes = inside ? Object.keys(node.attributes).map((name) => `${depth + 1} ${node.address} @${name}`) : [];
  return [
    `${depth} ${node.address}`,
    ...attributes,
    ...(inside ? node.children.flatMap((child) => flat(child, opened, depth + 1)) : []),
  ];
}

const answered = ({ name, attributes, children, address }: Node): Element => ({
  name,
  attributes,
  address,
  text: "",
  children: children.length,
});
const settled = async () => {
  for (let turn = 0; turn < 8; turn++) await new Promise((resolve) => setTimeout(resolve, 0));
};

describe("the rows of a document", () => {
  let document: Node;
  let asked: string[] = [];
  beforeEach(() => {
    asked = [];
    vi.stubGlobal("fetch", async (url: string) => {
      const { searchParams } = new URL(url, "http://here");
      const [address, first, limit] = [
        searchParams.get("address")!,
        Number(searchParams.get("first")),
        Number(searchParams.get("limit")),
      ];
      asked.push(`${address} ${first}`);
      const find = (node: Node): Node | undefined =>
        node.address === address ? node : node.children.map(find).find(Boolean);
      const children = find(document)!.children;
      return Response.json({
        total: children.length,
        items: children.slice(first - 1, first - 1 + limit).map(answered),
      });
    });
  });
  afterEach(() => vi.unstubAllGlobals());

  /** What the outline says of all its rows, once all has come. */
  async function rows(outline: Outline): Promise<string[]> {
    const read = () => Array.from({ length: outline.rows }, (_, index) => outline.row(index));
    while (read().some((row) => row.node === null)) await settled();
    return read().map(
      (row) => `${row.depth} ${row.node!.address}${row.attribute === null ? "" : ` @${row.attribute}`}`,
    );
  }

  it("are those of the flattened tree, whatever is opened and closed", async () => {
    for (let seed = 0; seed < 6; seed++) {
      const draw = random(seed);
      document = drawn(draw, draw.whole(0, 130));
      const outline = new Outline("u", 1);
      await settled();
      const opened = new Set(["/mcml/motion[1]"]);
      for (let step = 0; step < 10; step++) {
        const shown = await rows(outline);
        expect(shown).toEqual(flat(document, opened));
        const elements = shown.filter((row) => !row.includes("@") && row !== "0 /mcml").map((row) => row.split(" ")[1]);
        const address = itemAt(elements, draw.whole(0, elements.length - 1));
        outline.toggle(address!);
        if (!opened.has(address!)) opened.add(address!);
        else for (const one of [...opened].filter((other) => other.startsWith(address!))) opened.delete(one);
        await settled();
      }
    }
  });

  it("say where among their siblings they stand", async () => {
    document = drawn(random(1), 150);
    const outline = new Outline("u", 1);
    await settled();
    await rows(outline);
    const motion = itemAt(document.children, 2);
    const start = 3 + Object.keys(motion.attributes).length + 1;
    const row = outline.row(start + 119);
    expect([row.node!.address, row.place, row.siblings, row.open]).toEqual([
      "/mcml/motion[1]/frame[120]",
      119,
      150,
      false,
    ]);
  });

  it("of a frame are found from afar, and asked for in one window each", async () => {
    for (let seed = 0; seed < 3; seed++) {
      document = drawn(random(seed), 3000);
      const outline = new Outline("u", 1);
      await settled();
      const bone = itemAt(itemAt(document.children, 2).children, 0).children.at(-1)?.attributes.name ?? null;
      for (const frame of [2345, 1, 3000, 777]) {
        const index = await outline.rowOfFrame(frame, bone);
        const row = outline.row(index);
        expect(row.node!.address).toBe(
          `/mcml/motion[1]/frame[${frame}]${bone === null ? "" : `/frame_bone[${itemAt(itemAt(document.children, 2).children, 0).children.length}]`}`,
        );
      }
      expect(await outline.rowOfFrame(5, "no such bone")).toBe(await outline.rowOfFrame(5, null));
      expect(asked.length).toBe(new Set(asked).size);
      expect(asked.length).toBeLessThan(16);
      asked = [];
    }
  });

  it("are asked for again after a failure, not in a hurry, and its words go away", async () => {
    document = drawn(random(1), 10);
    let fails = true;
    let count = 0;
    const good = fetch;
    vi.stubGlobal("fetch", async (url: string) => {
      count++;
      return fails ? Response.json({ title: "No" }, { status: 503 }) : good(url);
    });
    vi.useFakeTimers();
    try {
      const outline = new Outline("u", 1);
      await vi.advanceTimersByTimeAsync(1);
      expect(outline.trouble.value).not.toBeNull();
      for (let drawing = 0; drawing < 20; drawing++) {
        await outline.rowOfFrame(3, null);
        await vi.advanceTimersByTimeAsync(1);
      }
      expect(count).toBe(1);
      fails = false;
      const version = outline.version.value;
      await vi.advanceTimersByTimeAsync(PAUSE);
      expect(outline.version.value).not.toBe(version);
      expect(await outline.rowOfFrame(3, null)).toBeGreaterThan(0);
      expect(outline.trouble.value).toBeNull();
    } finally {
      vi.useRealTimers();
    }
  });
});
