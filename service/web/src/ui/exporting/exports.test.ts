// @vitest-environment happy-dom
import { describe, expect, it, vi } from "vitest";
import { exportItems, lacking, unwritable, type Exported } from "./exports";

const formats = {
  items: [
    { name: "glb", writes: true },
    { name: "usd", writes: true },
    { name: "usda", writes: false },
  ],
  unsupported: [],
};
vi.stubGlobal(
  "fetch",
  async () => new Response(JSON.stringify(formats), { headers: { "content-type": "application/json" } }),
);
const known: Exported = { id: "x", markers: false, original: false, format: "bvh", unit: "cm", up: "Y", hasRate: true };
const texts = (markers: boolean) => exportItems({ ...known, markers, revision: 3 }).map((item) => item.text);

describe("what a document can be exported as", () => {
  it("has USD once the server says that it writes it", async () => {
    expect(texts(false)).toEqual(["MCML", "BVH", "ASF/AMC", "HTR", "glTF", "OpenSim", "CSV", "NumPy"]);
    await vi.waitFor(() => expect([...unwritable.value]).toEqual(["usda"]));
    expect(texts(false)).toContain("USD");
    expect(texts(true)).toEqual(["MCML", "C3D", "TRC", "glTF", "USD", "CSV", "NumPy"]);
    expect(exportItems({ ...known, markers: true, format: "" }).find((item) => item.text === "glTF")!.href).toContain(
      "/documents/x/export?format=glb",
    );
  });

  it("says what a guessed unit does to a file, with what mends it first", () => {
    const guessed: Exported = { ...known, unit: null, likelyUnit: "cm", up: null, likelyUp: "Z" };
    const said: object[] = [];
    const items = exportItems(guessed, { accept: (fact) => said.push(fact), give: () => said.push({}) });
    expect(items.slice(0, 2).map((item) => item.text)).toEqual(["Confirm cm", "Confirm Z"]);
    items.slice(0, 2).forEach((item) => item.run!());
    expect(said).toEqual([{ unit: "cm" }, { up: "Z" }]);
    const glb = items.find((item) => item.text === "glTF")!;
    expect(glb.detail).toBe("unit unknown, read as m, 100 times too large");
    expect(glb.href).toBeTruthy();
    expect(lacking({ ...guessed, likelyUnit: "m" }, "usd")!.text).toContain("100 times too small");
    expect(lacking({ ...guessed, likelyUnit: null }, "glb")!.text).toBe("unit unknown, read as m");
    expect(lacking(known, "glb")).toBe(null);
    expect(exportItems(known).every((item) => item.href)).toBe(true);
  });

  it("offers nothing that is refused, and where to give what is needed", () => {
    const bare: Exported = { ...known, format: "asf-amc", unit: null, likelyUnit: null, hasRate: false };
    const items = exportItems(bare, { give: () => undefined });
    expect(items.slice(0, 2).map((item) => item.text)).toEqual(["Give the unit", "Give the frame rate"]);
    for (const text of ["BVH", "glTF", "OpenSim"])
      expect(items.find((item) => item.text === text)).toMatchObject({ disabled: true, detail: "needs a frame rate" });
    expect(items.find((item) => item.text === "ASF/AMC")!.href).toBeTruthy();
    expect(lacking({ ...bare, format: "trc", original: true }, "trc")).toBe(null);
    expect(lacking({ ...bare, hasRate: true }, "trc")).toMatchObject({ refused: true, text: "needs a unit" });
  });
});
