/** Files that are looked at and not stored. */
import { signal } from "@preact/signals";
import { address, fetched, type Schemas } from "../api/client";
import { refuse } from "./notes";

export interface Looked { files: File[]; result: Schemas["InspectResult"] }
export const looked = signal<Looked | null>(null);

export async function lookFirst(files: File[]): Promise<void> {
  const form = new FormData();
  for (const file of files) form.append("file", file, file.name);
  try {
    const answer = await fetched(address("/inspect", {}, { positions: "f4" }), { method: "POST", body: form });
    looked.value = { files, result: await answer.json() };
  } catch (error) {
    refuse(error);
  }
}
