// @vitest-environment happy-dom
import { beforeAll, describe, expect, it } from "vitest";
import { learnFormats, LISTED } from "../../testing/formats";
import { extensionOf, formats, isOneClip, isRead, labelOf, readExtensions, writtenFormats } from "./formats";

beforeAll(learnFormats);

const names = (holds?: "bodies" | "markers") => writtenFormats(holds).map((one) => one.name);

describe("formats of the server", () => {
  it("are what it lists", () => {
    expect(formats()).toEqual(LISTED);
    expect(labelOf("tomorrow")).toBe("Tomorrow's");
    expect(labelOf("yesterday")).toBe("YESTERDAY");
  });

  it("are offered where they are written and hold what a clip has, the language first", () => {
    expect(names("bodies")).toEqual(["mcml", "bvh", "asf-amc", "htr", "glb", "tomorrow"]);
    expect(names("markers")).toEqual(names());
    expect(names()).not.toContain("usd");
    expect(writtenFormats().map(extensionOf).slice(0, 3)).toEqual([".mcml", ".bvh", ".zip"]);
  });

  it("tell which files are read, and which are a clip by themselves", () => {
    expect(readExtensions()).toEqual(
      expect.arrayContaining([".bvh", ".asf", ".amc", ".tomorrow", ".mcml", ".zip", ".tgz"]),
    );
    expect(["a.BVH", "a.tomorrow", "a.amc", "a.zip"].map(isRead)).toEqual([true, true, true, true]);
    expect(["a.glb", "a.txt", "bvh"].map(isRead)).toEqual([false, false, false]);
    expect(["a.BVH", "a.tomorrow", "a.film", "a.amc", "a.zip", "a.glb"].map(isOneClip)).toEqual([
      true,
      true,
      false,
      false,
      false,
      false,
    ]);
  });
});
