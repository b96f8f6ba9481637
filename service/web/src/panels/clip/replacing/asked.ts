/** Files that shall take the place of a clip's motion, from a menu or dropped on its page. */
import { signal } from "@preact/signals";
import { readExtensions } from "../../../state/session/formats";

export const replacing = signal<{ id: string; files: readonly File[] } | null>(null);

/** Open the chooser of files for a clip. */
export function chooseMotion(id: string): void {
  const input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.accept = readExtensions().join(",");
  input.onchange = () => void (replacing.value = { id, files: [...(input.files ?? [])] });
  input.click();
}
