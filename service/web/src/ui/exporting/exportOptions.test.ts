import { describe, expect, it } from "vitest";
import {
  exportByCommand,
  exportByCurl,
  exportClipsBody,
  exportClipsByCommand,
  exportClipsByCurl,
  fileNameOf,
  queryOf,
  rulerOf,
  type ExportOptions,
} from "./exportOptions";

const PLAIN: ExportOptions = {
  target: { for: "unreal" },
  unit: "",
  up: "",
  fps: null,
  height: null,
  inPlace: false,
  character: "",
  range: null,
};

describe("options of an export", () => {
  it("states only what differs from the clip", () => {
    expect(queryOf(PLAIN)).toEqual({ for: "unreal" });
    const all: ExportOptions = {
      target: { format: "bvh" },
      unit: "cm",
      up: "Z",
      fps: 30,
      height: 1.75,
      inPlace: true,
      character: "own",
      range: [11, 40],
    };
    expect(queryOf(all, 3)).toEqual({
      format: "bvh",
      unit: "cm",
      up: "Z",
      fps: 30,
      height: 1.75,
      in_place: true,
      character: "own",
      first: 11,
      last: 40,
      revision: 3,
    });
    expect(exportByCommand("abc", all, "http://x")).toBe(
      "mcml export abc --format bvh --unit cm --up Z --fps 30 --height 1.75 --in-place --character own --first 11 --last 40 --server http://x",
    );
    expect(exportByCurl("abc", PLAIN, "http://x", true)).toContain("MCML_TOKEN");
  });

  it("asks for several clips at once", () => {
    expect(exportClipsBody(["a", "b"], { ...PLAIN, height: 1.75 })).toEqual({
      selection: { documents: ["a", "b"] },
      for: "unreal",
      height: 1.75,
    });
    expect(exportClipsByCommand(["a", "b"], PLAIN, "http://x")).toBe("mcml export a b --for unreal --server http://x");
    expect(exportClipsByCurl(["a"], PLAIN, "http://x", false)).toBe(
      `curl -H "Content-Type: application/json" -d '{"selection":{"documents":["a"]},"for":"unreal"}' -o clips.zip 'http://x/api/v1/exports'`,
    );
  });

  it("marks round numbers up to the height", () => {
    expect(rulerOf(1.75, "cm")).toEqual({ height: 175, unit: "cm", marks: [0, 50, 100, 150] });
    expect(rulerOf(1.75, "m").marks).toEqual([0, 0.5, 1, 1.5]);
    expect(rulerOf(100, "mm").marks.length).toBeLessThan(8);
  });

  it("reads names of files in both forms", () => {
    expect(fileNameOf(`attachment; filename="walk.bvh"`, "x")).toBe("walk.bvh");
    expect(fileNameOf(`attachment; filename*=UTF-8''%EA%B1%B7%EA%B8%B0.bvh`, "x")).toBe("걷기.bvh");
    expect(fileNameOf(null, "walk.bvh")).toBe("walk.bvh");
  });
});
