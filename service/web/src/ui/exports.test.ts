// @vitest-environment happy-dom
import { describe, expect, it, vi } from "vitest";
import { exportItems, unwritable } from "./exports";

const formats = { items: [{ name: "glb", writes: true }, { name: "usd", writes: true }, { name: "usda", writes: false }], unsupported: [] };
vi.stubGlobal("fetch", async () => new Response(JSON.stringify(formats), { headers: { "content-type": "application/json" } }));
const texts = (markers: boolean) => exportItems("x", { markers, original: false, format: "bvh", revision: 3 }).map((item) => item.text);

describe("what a document can be exported as", () => {
  it("has USD once the server says that it writes it", async () => {
    expect(texts(false)).toEqual(["MCML", "BVH", "ASF/AMC", "HTR", "glTF", "OpenSim", "CSV, NumPy"]);
    await vi.waitFor(() => expect([...unwritable.value]).toEqual(["usda"]));
    expect(texts(false)).toContain("USD");
    expect(texts(true)).toEqual(["MCML", "C3D", "TRC", "glTF", "USD", "CSV, NumPy"]);
    expect(exportItems("x", { markers: true, original: false, format: "" }).find((item) => item.text === "glTF")!.href).toContain("/documents/x/export?format=glb");
  });
});
