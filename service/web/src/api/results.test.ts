import { describe, expect, it } from "vitest";
import { readBlock, rowsOf } from "./results";

describe("blocks of made motion", () => {
  it("are a length, JSON with spaces at its end, and positions", () => {
    const text = new TextEncoder().encode('{"value":{"a":"ü"},"motion":{"shape":[1,2,3]}}');
    const size = Math.ceil(text.length / 4) * 4;
    const block = new Uint8Array(4 + size + 24).fill(32, 4, 4 + size);
    new DataView(block.buffer).setUint32(0, size, true);
    block.set(text, 4);
    block.set(new Uint8Array(new Float32Array([1, 2, 3, 4, 5, NaN]).buffer), 4 + size);
    const read = readBlock<{ a: string }>(block.buffer);
    expect(read.value.a).toBe("ü");
    expect(read.motion.shape).toEqual([1, 2, 3]);
    expect(read.positions).toEqual(new Float32Array([1, 2, 3, 4, 5, NaN]));
  });
});

it("rows of a table are read by their columns", () => {
  const part = {
    kind: "table",
    data: {
      columns: [{ name: "a" }, { name: "b" }],
      rows: [
        [1, "x"],
        [2, null],
      ],
    },
  } as never;
  expect(rowsOf(part)).toEqual([
    { a: 1, b: "x" },
    { a: 2, b: null },
  ]);
  expect(rowsOf(undefined)).toEqual([]);
});
