// @vitest-environment happy-dom
import { beforeAll, describe, expect, it } from "vitest";
import { learnFormats, LISTED } from "../../testing/formats";
import { exportItems, lacking, type Exported } from "./exports";

beforeAll(learnFormats);

const of = (name: string) => LISTED.find((one) => one.name === name)!;
const known: Exported = { id: "x", markers: false, original: false, format: "bvh", unit: "cm", up: "Y", hasRate: true };
const texts = (markers: boolean) => exportItems({ ...known, markers, revision: 3 }).map((item) => item.text);

describe("what a document can be exported as", () => {
  it("is what the server writes and what holds the clip", () => {
    expect(texts(false)).toEqual([
      "For Blender",
      "For Lab",
      "MCML",
      "BVH",
      "ASF/AMC",
      "HTR",
      "glTF",
      "Tomorrow's",
      "CSV",
      "NumPy",
    ]);
    expect(texts(true)).toEqual([
      "For Blender",
      "For Lab",
      "MCML",
      ...LISTED.filter((one) => one.writes && one.name !== "mcml").map((one) => one.label),
      "CSV",
      "NumPy",
    ]);
    const points = exportItems({ ...known, markers: true });
    const detail = (text: string) => points.find((item) => item.text === text)!.detail;
    expect([detail("BVH"), detail("TRC")]).toEqual(["skeleton made from markers", undefined]);
    const two = exportItems({ ...known, markers: true, centres: ["Anna:left_up_leg", "Bea:left_up_leg"] });
    expect(two.find((item) => item.text === "BVH")).toMatchObject({ disabled: true });
    expect(two.find((item) => item.text === "TRC")!.href).toBeTruthy();
    expect(exportItems({ ...known, markers: true, format: "" }).find((item) => item.text === "glTF")!.href).toContain(
      "/documents/x/export?format=glb",
    );
  });

  it("leaves for a program in the format that it reads, where the server writes it", () => {
    const item = (markers: boolean, text: string) =>
      exportItems({ ...known, markers }).find((one) => one.text === text);
    expect(item(false, "For Blender")).toMatchObject({ detail: "BVH" });
    expect(item(false, "For Blender")!.href).toContain("/documents/x/export?for=blender");
    expect(item(true, "For Blender")).toMatchObject({ detail: "glTF" });
    // The server writes no USD.
    expect(item(false, "For Maya")).toBe(undefined);
    const bare = exportItems({ ...known, markers: true, unit: null });
    expect(bare.find((one) => one.text === "For Lab")).toMatchObject({ disabled: true, detail: "needs a unit" });
  });

  it("says what a guessed unit does to a file, with what mends it first", () => {
    const guessed: Exported = { ...known, unit: null, likelyUnit: "cm", up: null, likelyUp: "Z" };
    const said: object[] = [];
    const items = exportItems(guessed, { accept: (fact) => said.push(fact), give: () => said.push({}) });
    expect(items.slice(0, 2).map((item) => item.text)).toEqual(["Confirm cm", "Confirm Z"]);
    items.slice(0, 2).forEach((item) => item.run!());
    expect(said).toEqual([{ unit: "cm" }, { up: "Z" }]);
    const glb = items.find((item) => item.text === "glTF")!;
    expect(glb.detail).toBe("unit unknown, read as m, 100× too large");
    expect(glb.href).toBeTruthy();
    expect(lacking({ ...guessed, likelyUnit: "m" }, of("usd"))!.text).toContain("100× too small");
    expect(lacking({ ...guessed, likelyUnit: null }, of("glb"))!.text).toBe("unit unknown, read as m");
    expect(lacking(known, of("glb"))).toBe(null);
    expect(exportItems(known).every((item) => item.href)).toBe(true);
  });

  it("offers nothing that is refused, and where to give what is needed", () => {
    const bare: Exported = { ...known, format: "asf-amc", unit: null, likelyUnit: null, hasRate: false };
    const items = exportItems(bare, { give: () => undefined });
    expect(items.slice(0, 2).map((item) => item.text)).toEqual(["Set unit", "Set frame rate"]);
    for (const text of ["BVH", "glTF", "Tomorrow's"])
      expect(items.find((item) => item.text === text)).toMatchObject({ disabled: true, detail: "needs a frame rate" });
    expect(items.find((item) => item.text === "ASF/AMC")!.href).toBeTruthy();
    expect(lacking({ ...bare, format: "trc", original: true }, of("trc"))).toBe(null);
    expect(lacking({ ...bare, hasRate: true }, of("trc"))).toMatchObject({ refused: true, text: "needs a unit" });
    const trial = (format: string, beside = false) =>
      exportItems({ ...known, markers: true, format, beside }).find((item) => item.text === "Trial");
    expect(trial("trc")).toMatchObject({ disabled: true, detail: "needs force plates" });
    expect(trial("trc", true)!.href).toBeTruthy();
    expect(trial("c3d")!.href).toBeTruthy();
    const face = { name: "face", needs: ["blend_shapes"], assumes: "", markers: true };
    expect(lacking(known, face)).toMatchObject({ refused: true, text: "needs blend shapes of a face" });
  });
});
