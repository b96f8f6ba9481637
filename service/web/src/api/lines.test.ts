import { describe, expect, it } from "vitest";
import { random } from "../testing/random";
import { jsonLines } from "./lines";

const answer = (parts: Uint8Array[]) =>
  new Response(
    new ReadableStream({
      start: (control) => {
        for (const part of parts) control.enqueue(part);
        control.close();
      },
    }),
  );
const all = async (found: AsyncGenerator) => {
  const items = [];
  for await (const one of found) items.push(one);
  return items;
};

describe("lines of JSON", () => {
  it("come whole wherever the answer is cut, inside letters too", async () => {
    const items = [{ name: "걷기" }, { n: 1 }, ["é", null]];
    for (const end of ["\n", ""]) {
      const bytes = new TextEncoder().encode(items.map((one) => JSON.stringify(one)).join("\n") + end);
      for (let seed = 0; seed < 60; seed++) {
        const draw = random(seed);
        const parts: Uint8Array[] = [];
        for (let at = 0; at < bytes.length;) {
          const size = draw.whole(1, 9);
          parts.push(bytes.slice(at, at + size));
          at += size;
        }
        expect(await all(jsonLines(answer(parts)))).toEqual(items);
      }
    }
    expect(await all(jsonLines(answer([])))).toEqual([]);
  });
});
