import { itemAt, numberAt } from "../../lists";
import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { drawThumbnail, fromBase64, readThumbnail } from "./thumbnail";

interface Case {
  bytes: string;
  face: boolean;
  markers: boolean;
  bones: [number, number, number, number][];
  loop: [number, number][][];
  scrub: [number, number][][];
  ground: number[];
  seconds: number;
  aspect: number;
  step: number;
  farthest: number[];
  highest: number[];
}
// Written by the tests in Python, which make thumbnails and read them in their own way.
const { MCML_THUMBNAILS } = process.env;
const cases: Case[] = MCML_THUMBNAILS ? JSON.parse(readFileSync(MCML_THUMBNAILS, "utf8")) : [];
const INKS = { sides: ["c", "l", "r"] as [string, string, string], line: "line" };

/** A pen that remembers where lines went. */
function recorder() {
  const lines: { style: string; points: [number, number][] }[] = [];
  const discs: [number, number][] = [];
  let path: [number, number][] = [];
  const pen = {
    strokeStyle: "",
    fillStyle: "",
    lineWidth: 1,
    globalAlpha: 1,
    lineCap: "",
    lineJoin: "",
    clearRect: () => {},
    fill: () => {},
    beginPath: () => {
      path = [];
    },
    moveTo: (x: number, y: number) => path.push([x, y]),
    lineTo: (x: number, y: number) => path.push([x, y]),
    arc: (x: number, y: number) => discs.push([x, y]),
    stroke() {
      lines.push({ style: pen.strokeStyle, points: path });
    },
  };
  return { pen: pen as unknown as CanvasRenderingContext2D, lines, discs };
}

describe.skipIf(!cases.length)("thumbnails that the repository makes", () => {
  it.each(cases.map((one, index) => [index, one] as const))("%i: are read as they were written", (_, one) => {
    const found = readThumbnail(fromBase64(one.bytes));
    const [poses, moments] = [one.loop.length, one.scrub.length];
    expect([found.face, found.markers, found.points, found.loopPoses, found.scrubPoses]).toEqual([
      one.face,
      one.markers,
      itemAt(one.loop, 0).length,
      poses,
      moments,
    ]);
    expect(found.bones.map(({ a, b, side, depth }) => [a, b, side, depth])).toEqual(one.bones);
    expect([found.seconds, found.aspect, found.groundStep]).toEqual([one.seconds, one.aspect, one.step]);
    expect([...found.loopGround, ...found.scrubGround]).toEqual(one.ground);
    const places = (bytes: Uint8Array) => [...bytes].map((value, at) => (value / 255) * (at % 2 ? 1 : one.aspect));
    expect(
      Math.max(0, ...places(found.loop).map((value, at) => Math.abs(value - numberAt(one.loop.flat(2), at)))),
    ).toBeLessThan(1e-9);
    expect(
      Math.max(0, ...places(found.scrub).map((value, at) => Math.abs(value - numberAt(one.scrub.flat(2), at)))),
    ).toBeLessThan(1e-9);
    expect(one.farthest).toContain(found.poster);
    expect(one.highest).toContain(found.head);
  });

  it.each(cases.map((one, index) => [index, one] as const))("%i: are drawn where the points are", (_, one) => {
    const thumb = readThumbnail(fromBase64(one.bytes));
    const [width, height] = [208, 144];
    const scale = Math.min(height * 0.78, (width * 0.86) / one.aspect);
    const put = ([x, y]: [number, number]): [number, number] => [
      (width - scale * one.aspect) / 2 + x * scale,
      height * 0.88 - scale + y * scale,
    ];
    for (const [whole, poses] of [
      [false, one.loop],
      [true, one.scrub],
    ] as const) {
      poses.forEach((pose, index) => {
        const { pen, lines, discs } = recorder();
        drawThumbnail(pen, thumb, width, height, poses.length > 1 ? index / (poses.length - 1) : 0, INKS, whole);
        const floor = lines.filter(({ style }) => style === "line");
        expect(floor.length).toBe(one.face ? 0 : 1);
        const drawn = one.markers
          ? discs
          : lines
              .filter(({ style }) => style !== "line")
              .map(({ points }) => points)
              .flat();
        const wanted = one.markers
          ? pose.map(put)
          : one.bones.flatMap(([a, b]) => [put(itemAt(pose, a)), put(itemAt(pose, b))]);
        expect(drawn.length).toBe(wanted.length);
        const away = drawn.map(([x, y], at) => Math.hypot(x - itemAt(wanted, at)[0], y - itemAt(wanted, at)[1]));
        expect(Math.max(0, ...away)).toBeLessThan(1e-6 * height);
      });
    }
  });
});

/** One point that stands, two poses; the ground goes by. */
function walking(way: number[]): Uint8Array {
  const bytes = new Uint8Array(20 + way.length * 2 + 2 + way.length + 1);
  bytes.set([77, 84, 49, 2, 1, 0, way.length, 1]);
  const view = new DataView(bytes.buffer);
  [1, 0.5, 1 / 128].forEach((value, at) => view.setFloat32(8 + at * 4, value, true));
  bytes.set(way, 20 + way.length * 2 + 2);
  return bytes;
}

describe("the ground under a walker", () => {
  it("slides on where its way begins again at 0, at every size of the picture", () => {
    for (const height of [36, 44, 96, 144, 320]) {
      const thumb = readThumbnail(walking([250, 4]));
      const ticks = (phase: number) => {
        const { pen, lines } = recorder();
        drawThumbnail(pen, thumb, height * 1.5, height, phase, INKS);
        return itemAt(lines, 0)
          .points.filter(([, y]) => y === height)
          .map(([x]) => x);
      };
      const gap = numberAt(ticks(0), 1) - numberAt(ticks(0), 0);
      for (let at = 0; at <= 20; at++) {
        // From 250 to 260: half a step each.
        const moved = (numberAt(ticks(0), 0) - numberAt(ticks(at / 20), 0) - (at / 2 / 128) * height * 0.78) / gap;
        expect(Math.abs(moved - Math.round(moved)), `height ${height}, ${at} of 20`).toBeLessThan(1e-6);
      }
      expect(gap).toBeGreaterThan(height / 6);
    }
  });
});

describe("what is no thumbnail", () => {
  it("is refused", () => {
    const good = walking([0, 0]);
    expect(() => readThumbnail(good)).not.toThrow();
    expect(() => readThumbnail(good.subarray(0, good.length - 1))).toThrow();
    expect(() => readThumbnail(good.subarray(0, 19))).toThrow();
    expect(() => readThumbnail(new TextEncoder().encode("MT2 and something more than twenty bytes"))).toThrow();
    expect(() => readThumbnail(new Uint8Array())).toThrow();
  });

  it("is read from the middle of other bytes too", () => {
    const room = new Uint8Array(100).fill(9);
    room.set(walking([3, 5]), 13);
    expect([...readThumbnail(room.subarray(13, 13 + walking([3, 5]).length)).loopGround]).toEqual([3, 5]);
  });
});
