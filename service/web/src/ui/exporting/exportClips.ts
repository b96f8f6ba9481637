/** Several clips in one archive, for a program or in a format. */
import { address, fetched } from "../../api/client";
import { presets, writtenFormats } from "../../state/session/formats";
import { refuse } from "../../state/session/notes";
import { w } from "../../words";
import type { Item } from "../Menu";
import { START } from "./ExportFields";
import { exportClipsBody, type ExportOptions } from "./exportOptions";
import { saveBlob } from "./saveBlob";

/** Whether it was saved. */
export async function exportClips(ids: readonly string[], options: ExportOptions): Promise<boolean> {
  try {
    const answer = await fetched(address("/exports"), {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(exportClipsBody(ids, options)),
    });
    saveBlob(await answer.blob(), `clips ${Object.values(options.target)[0]}.zip`);
    return true;
  } catch (error) {
    refuse(error);
    return false;
  }
}

/** onOptions: opens the dialog of all options. */
export const exportClipsItems = (ids: string[], onOptions: () => void): Item[] => [
  { text: w("button.exportOptions"), icon: "export", run: onOptions },
  ...presets("bodies").map(({ preset, format }) => ({
    text: w("label.exportFor", { program: preset.title }),
    detail: format.label,
    run: () => void exportClips(ids, { ...START, target: { for: preset.name } }),
  })),
  ...writtenFormats().map(({ name, label }) => ({
    text: w("label.exportAs", { format: label }),
    run: () => void exportClips(ids, { ...START, target: { format: name } }),
  })),
];
