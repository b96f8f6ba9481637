import { describe, expect, it } from "vitest";
import { readNpy } from "./npy";

/** As numpy.save writes it. */
function file(descr: string, shape: string, data: ArrayBufferLike, version = 1): ArrayBuffer {
  const before = version === 1 ? 10 : 12;
  let head = `{'descr': '${descr}', 'fortran_order': False, 'shape': ${shape}, }`;
  head = head.padEnd(Math.ceil((before + head.length + 1) / 64) * 64 - before - 1) + "\n";
  const bytes = new Uint8Array(before + head.length + data.byteLength);
  bytes.set([0x93, ...[..."NUMPY"].map((one) => one.charCodeAt(0)), version, 0]);
  const view = new DataView(bytes.buffer);
  if (version === 1) view.setUint16(8, head.length, true);
  else view.setUint32(8, head.length, true);
  bytes.set(new TextEncoder().encode(head), before);
  bytes.set(new Uint8Array(data), before + head.length);
  return bytes.buffer;
}

describe("NumPy files", () => {
  it.each([
    ["<f4", "(2, 2)", new Float32Array([1, -2.5, 0, 4]), [2, 2]],
    ["<f8", "(3,)", new Float64Array([1, 1e-300, NaN]), [3]],
    ["<i4", "(1, 2, 1)", new Int32Array([-7, 8]), [1, 2, 1]],
    ["|u1", "(3,)", new Uint8Array([0, 1, 255]), [3]],
    ["<f8", "()", new Float64Array([9]), []],
    ["<f4", "(0, 3)", new Float32Array([]), [0, 3]],
  ] as const)("%s %s", (descr, shape, values, sizes) => {
    for (const version of [1, 2]) {
      const found = readNpy(file(descr, shape, values.buffer, version));
      expect(found.shape).toEqual([...sizes]);
      expect(found.values).toEqual(values);
    }
  });

  it("integers of 64 bits become numbers", () => {
    expect([...readNpy(file("<i8", "(2,)", new BigInt64Array([-5n, 2n ** 40n]).buffer)).values]).toEqual([-5, 2 ** 40]);
  });

  it("anything else is refused", () => {
    expect(() => readNpy(new TextEncoder().encode('{"title": "Not found"}').buffer)).toThrow("NumPy");
    expect(() => readNpy(file("<c8", "(1,)", new Float32Array(2).buffer))).toThrow("<c8");
  });
});
