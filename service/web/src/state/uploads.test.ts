// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { grouped } from "./uploads";

const file = (path: string): File => Object.assign(new File([""], path.split("/").at(-1)!), { path: `/${path}` });
const names = (groups: File[][]) => groups.map((group) => group.map((one) => (one as File & { path: string }).path.slice(1)).sort()).sort();

describe("files that are stored together", () => {
  it("are an ASF and the AMCs of its folder", () => {
    const files = ["a/02.asf", "b/05.asf", "a/02_01.amc", "a/02_02.AMC", "b/05_01.amc", "a/walk.bvh"].map(file);
    expect(names(grouped(files))).toEqual([["a/02.asf", "a/02_01.amc", "a/02_02.AMC"], ["a/walk.bvh"], ["b/05.asf", "b/05_01.amc"]]);
  });

  it("are none where there is no ASF: each AMC by itself is refused by itself", () => {
    expect(names(grouped(["a/1.amc", "a/2.amc", "b/3.asf"].map(file)))).toEqual([["a/1.amc"], ["a/2.amc"], ["b/3.asf"]]);
  });

  it("are told by folder also where a dialogue chose them", () => {
    const chosen = (path: string) => Object.defineProperty(new File([""], path.split("/").at(-1)!), "webkitRelativePath", { value: path });
    expect(grouped(["x/1.asf", "y/1.amc", "x/1.amc"].map(chosen)).map((group) => group.length).sort()).toEqual([1, 2]);
    expect(grouped([new File([""], "1.asf"), new File([""], "1.amc")]).length).toBe(1);
  });

  it("are every file once", () => {
    const files = ["a/1.amc", "2.bvh", "3.zip", "a/4.asf", "b/5.amc", "b/6.htr"].map(file);
    expect(grouped(files).flat().length).toBe(files.length);
    expect(new Set(grouped(files).flat())).toEqual(new Set(files));
    expect(grouped([])).toEqual([]);
  });
});
