/** What a document can be exported as, as items of a menu. */
import { address } from "../api/client";
import type { Item } from "./Menu";
import { w } from "../words";

const BODY_FORMATS = [["bvh", "BVH"], ["asf-amc", "ASF/AMC"], ["htr", "HTR"]];
const MARKER_FORMATS = [["c3d", "C3D"], ["trc", "TRC"]];

export function exportItems(id: string, { markers, original, format, revision }: { markers: boolean; original: boolean; format: string; revision?: number }): Item[] {
  const formats = markers ? MARKER_FORMATS : BODY_FORMATS;
  const query = revision === undefined ? {} : { revision };
  return [
    { text: "MCML", detail: ".mcml", href: address("/documents/{id}/mcml", { id }, query), download: true },
    ...formats.map(([name, text]) => ({ text, detail: name === format && original ? w("kept") : undefined, href: address("/documents/{id}/export", { id }, { ...query, format: name }), download: true })),
    { text: "CSV, NumPy", detail: ".npz", href: address("/documents/{id}/frames", { id }, { ...query, format: "npz" }), download: true },
  ];
}

