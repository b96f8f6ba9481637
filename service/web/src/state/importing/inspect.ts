/** Files that are looked at and not stored. */
import { signal } from "@preact/signals";
import { address, fetched, type Schemas } from "../../api/client";
import type { Missed } from "./dropped";
import { refuse } from "../session/notes";

export interface Looked {
  files: File[];
  result: Schemas["InspectResult"];
}
export const looked = signal<Looked | null>(null);

/** missed: what of a drop is no file; told with the others. */
export async function lookFirst(files: File[], missed: Missed[] = []): Promise<void> {
  if (!files.length) {
    looked.value = { files, result: { clips: [], problems: missed as Schemas["FileProblem"][] } };
    return;
  }
  const form = new FormData();
  for (const file of files) form.append("file", file, file.name);
  try {
    const answer = await fetched(address("/inspect", {}, { positions: "f4" }), { method: "POST", body: form });
    const result = (await answer.json()) as Schemas["InspectResult"];
    looked.value = {
      files,
      result: { ...result, problems: [...result.problems, ...(missed as Schemas["FileProblem"][])] },
    };
  } catch (error) {
    refuse(error);
  }
}
