// @vitest-environment happy-dom
import { expect, it } from "vitest";
import { windowed } from "./proposed";

it("frames of a motion that comes in windows are put together", async () => {
  const read: number[] = [];
  const window = (place: number) => {
    read.push(place);
    const first = place * 4096 + 1;
    return Promise.resolve(Float32Array.from({ length: 4096 * 2 }, (_, at) => first + (at >> 1)));
  };
  expect([...(await windowed(4095, 4098, 2, window))]).toEqual([4095, 4095, 4096, 4096, 4097, 4097, 4098, 4098]);
  expect(read).toEqual([0, 1]);
  expect([...(await windowed(1, 2, 2, window))]).toEqual([1, 1, 2, 2]);
  expect(await windowed(5, 4, 2, window)).toHaveLength(0);
});
