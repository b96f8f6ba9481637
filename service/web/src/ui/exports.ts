/** What a document can be exported as, as items of a menu. */
import { signal } from "@preact/signals";
import { address, get } from "../api/client";
import type { Item } from "./Menu";
import { w } from "../words";

const BODY_FORMATS = [["bvh", "BVH"], ["asf-amc", "ASF/AMC"], ["htr", "HTR"]];
const MARKER_FORMATS = [["c3d", "C3D"], ["trc", "TRC"]];
const SCENES = [["glb", "glTF"], ["usd", "USD"]];
const ANGLES = [["mot", "OpenSim"]];

/** Formats that this server cannot write: not every one has the library. USD, until it is known. */
export const unwritable = signal<ReadonlySet<string>>(new Set(["usd"]));
let asked = false;

/** Ask once what the server writes. */
export function askWritable(): void {
  if (asked) return;
  asked = true;
  get("/formats").then(
    (list) => { unwritable.value = new Set(list.items.filter((one) => one.writes === false).map((one) => one.name)); },
    () => { asked = false; },
  );
}

export function exportItems(id: string, { markers, original, format, revision }: { markers: boolean; original: boolean; format: string; revision?: number }): Item[] {
  askWritable();
  const formats = [...(markers ? MARKER_FORMATS : BODY_FORMATS), ...SCENES, ...(markers ? [] : ANGLES)].filter(([name]) => !unwritable.value.has(name));
  const query = revision === undefined ? {} : { revision };
  return [
    { text: "MCML", detail: ".mcml", href: address("/documents/{id}/mcml", { id }, query), download: true },
    ...formats.map(([name, text]) => ({ text, detail: name === format && original ? w("kept") : undefined, href: address("/documents/{id}/export", { id }, { ...query, format: name }), download: true })),
    { text: "CSV, NumPy", detail: ".npz", href: address("/documents/{id}/frames", { id }, { ...query, format: "npz" }), download: true },
  ];
}

