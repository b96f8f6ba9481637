/** A server that lists formats, some of which no real one has. */
import { vi } from "vitest";
import { formats, type Format, type Preset } from "../state/session/formats";

const part = (name: string) => ({ name, title: name, extensions: [`.${name}`] });

const format = (
  name: string,
  label: string,
  holds: "bodies" | "markers" | "both",
  more: Partial<Format> = {},
): Format => ({
  name,
  title: label,
  label,
  parts: [{ ...part(name), title: label }],
  convention: "any",
  bodies: holds !== "markers",
  markers: holds !== "bodies",
  needs: ["frame_time"],
  assumes: "",
  states: [],
  reads: true,
  takes: false,
  beside: [],
  states_beside: [],
  extensions: (more.parts ?? [part(name)]).flatMap((one) => one.extensions),
  skins: false,
  writes: true,
  ...more,
});

export const LISTED: Format[] = [
  format("bvh", "BVH", "bodies"),
  format("asf-amc", "ASF/AMC", "bodies", { needs: [], parts: [part("asf"), part("amc")] }),
  format("htr", "HTR", "bodies", { needs: [] }),
  format("c3d", "C3D", "markers", { states: ["force_plates"] }),
  format("trial", "Trial", "markers", { needs: ["force_plates"], reads: false }),
  format("trc", "TRC", "markers", {
    needs: ["frame_time", "unit"],
    beside: [".mot", ".sto"],
    states_beside: ["force_plates"],
  }),
  format("glb", "glTF", "both", { assumes: "m", reads: false, skins: true }),
  format("film", "Film", "bodies", { takes: true, writes: false }),
  format("usd", "USD", "both", { assumes: "cm", reads: false, writes: false }),
  format("tomorrow", "Tomorrow's", "both", { assumes: "cm" }),
  format("mcml", "MCML", "both", { needs: [] }),
];

export const PRESETS: Preset[] = [
  {
    name: "blender",
    title: "Blender",
    bodies: { format: "bvh", unit: "m", up: "Y", fps: null },
    markers: { format: "glb", unit: "m", up: "Y", fps: null },
    why: "",
  },
  {
    name: "maya",
    title: "Maya",
    bodies: { format: "usd", unit: "cm", up: "Y", fps: null },
    markers: { format: "usd", unit: "cm", up: "Y", fps: null },
    why: "",
  },
  {
    name: "lab",
    title: "Lab",
    bodies: { format: "bvh", unit: "m", up: "Y", fps: null },
    markers: { format: "trc", unit: "m", up: "Y", fps: null },
    why: "",
  },
];

/** Have the formats asked of that server. */
export async function learnFormats(): Promise<void> {
  const answer = JSON.stringify({ items: LISTED, presets: PRESETS, unsupported: [] });
  vi.stubGlobal("fetch", async () => new Response(answer, { headers: { "content-type": "application/json" } }));
  await vi.waitFor(() => {
    if (!formats().length) throw new Error("not yet");
  });
  vi.unstubAllGlobals();
}
