/** What a drop holds: its files, folders walked, and what of it can be no file. */
import type { Problem } from "../../api/client";
import { w } from "../../words";

/** A file or folder of which nothing can be sent. */
export interface Missed {
  file: string;
  problem: Problem;
}
export interface Dropped {
  files: File[];
  missed: Missed[];
}

/** Where a file is, as far as the browser says; "" at the top. */
export function folderOf(file: File): string {
  const path = (file as File & { path?: string }).path ?? file.webkitRelativePath ?? "";
  return path.slice(0, path.lastIndexOf("/") + 1).replace(/^\//, "");
}

const unreadable = (file: string, error: unknown): Missed => ({
  file,
  problem: {
    title: w("error.cannotRead"),
    detail: (error as Error)?.message || String(error),
    remedy: w("error.cannotReadHelp"),
  },
});

/** Every item of a drop is in the answer, as a file or as what was missed. */
export async function filesOf(transfer: Pick<DataTransfer, "items" | "files">): Promise<Dropped> {
  const found: Dropped = { files: [], missed: [] };
  // Items are gone after the first wait.
  const items = [...transfer.items]
    .filter((item) => item.kind === "file")
    .map((item) => ({ entry: item.webkitGetAsEntry?.() ?? null, file: item.getAsFile() }));
  if (!items.length) return { files: [...transfer.files], missed: [] };
  const walk = async (entry: FileSystemEntry): Promise<void> => {
    const path = entry.fullPath.replace(/^\//, "");
    try {
      if (entry.isFile) {
        const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
        found.files.push(Object.assign(file, { path: entry.fullPath }));
        return;
      }
      const reader = (entry as FileSystemDirectoryEntry).createReader();
      let held = 0;
      // A reader answers a hundred entries at a time.
      for (;;) {
        const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
        held += some.length;
        if (!some.length) break;
        for (const one of some) await walk(one);
      }
      if (!held)
        found.missed.push({
          file: `${path}/`,
          problem: { title: w("label.emptyFolder"), remedy: w("help.emptyFolderHelp") },
        });
    } catch (error) {
      found.missed.push(unreadable(path, error));
    }
  };
  for (const { entry, file } of items) {
    if (entry) await walk(entry);
    else if (file) found.files.push(file);
    else found.missed.push(unreadable(w("label.droppedItem"), w("error.noFile")));
  }
  return found;
}
