/** Several clips in one archive, for a program or in a format. */
import { address, fetched } from "../../api/client";
import { presets, writtenFormats } from "../../state/session/formats";
import { refuse } from "../../state/session/notes";
import { w } from "../../words";
import type { Item } from "../Menu";
import { saveBlob } from "./saveBlob";

async function exportClips(ids: string[], chosen: { format: string } | { for: string }): Promise<void> {
  try {
    const answer = await fetched(address("/exports"), {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify({ selection: { documents: ids }, ...chosen }),
    });
    saveBlob(await answer.blob(), `clips ${Object.values(chosen)[0]}.zip`);
  } catch (error) {
    refuse(error);
  }
}

/** The choices of a menu. */
export const exportClipsItems = (ids: string[]): Item[] => [
  ...presets("bodies").map(({ preset, format }) => ({
    text: w("label.exportFor", { program: preset.title }),
    detail: format.label,
    run: () => void exportClips(ids, { for: preset.name }),
  })),
  ...writtenFormats().map(({ name, label }) => ({
    text: w("label.exportAs", { format: label }),
    run: () => void exportClips(ids, { format: name }),
  })),
];
