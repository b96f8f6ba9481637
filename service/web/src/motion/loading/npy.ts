/** Arrays as numpy.save writes them: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html */
import { numberAt } from "../../lists";

export type Numbers =
  Float64Array | Float32Array | Int32Array | Uint8Array | Int8Array | Int16Array | Uint16Array | Uint32Array;

export interface NdArray {
  shape: number[];
  values: Numbers;
}

const KINDS = {
  "<f8": Float64Array,
  "<f4": Float32Array,
  "<i4": Int32Array,
  "<u4": Uint32Array,
  "<i2": Int16Array,
  "<u2": Uint16Array,
  "|i1": Int8Array,
  "|u1": Uint8Array,
  "|b1": Uint8Array,
} as const;

/** Error for what is no such file, or holds another kind of numbers. Integers of 64 bits become floating point. */
export function readNpy(buffer: ArrayBuffer): NdArray {
  const bytes = new Uint8Array(buffer);
  if (bytes[0] !== 0x93 || String.fromCharCode(...bytes.subarray(1, 6)) !== "NUMPY") throw new Error("no NumPy file");
  const view = new DataView(buffer);
  const wide = numberAt(bytes, 6) >= 2;
  const start = wide ? 12 : 10;
  const size = wide ? view.getUint32(8, true) : view.getUint16(8, true);
  const head = new TextDecoder("latin1").decode(bytes.subarray(start, start + size));
  const kind = /'descr': '([^']+)'/.exec(head)?.[1] ?? "";
  const shape = [...(/'shape': \(([^)]*)\)/.exec(head)?.[1] ?? "").matchAll(/\d+/g)].map(([one]) => Number(one));
  if (/'fortran_order': True/.test(head)) throw new Error("columns first");
  const count = shape.reduce((product, one) => product * one, 1);
  const data = buffer.slice(start + size);
  if (kind === "<i8" || kind === "<u8") {
    const long = kind === "<i8" ? new BigInt64Array(data, 0, count) : new BigUint64Array(data, 0, count);
    return { shape, values: Float64Array.from(long, Number) };
  }
  const made = KINDS[kind as keyof typeof KINDS];
  if (!made) throw new Error(`numbers of the kind ${kind}`);
  return { shape, values: new made(data, 0, count) };
}
