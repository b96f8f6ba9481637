/** Copy or move the picked clips into a project, one that is there or a new one. */
import { useState } from "preact/hooks";
import { ask, get } from "../../api/client";
import * as library from "../../state/library/library";
import { note, refuse } from "../../state/session/notes";
import { Dialog } from "../../ui/Dialog";
import { useAsync } from "../../ui/useAsync";
import { w } from "../../words";

export function ToProject({ ids, move, onClose }: { ids: string[]; move: boolean; onClose: () => void }) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const [name, setName] = useState("");
  const [busy, setBusy] = useState(false);
  const act = async () => {
    setBusy(true);
    try {
      await (move ? moved : copied)(ids, name.trim());
      onClose();
    } catch (error) {
      refuse(error);
    } finally {
      setBusy(false);
    }
  };
  return (
    <Dialog title={w(move ? "button.moveToProject" : "button.copyToProject")} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (name.trim() && !busy) void act();
        }}
      >
        <p class="dim">{w(move ? "help.moveHelp" : "help.copyHelp")}</p>
        <p class="row">
          <input
            class="field grow"
            autoFocus
            list="projects-there"
            maxLength={256}
            aria-label={w("label.project")}
            placeholder={w("label.projectOrNew")}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button type="submit" class="button primary" disabled={!name.trim() || busy}>
            {w(move ? "button.move" : "button.copy")}
          </button>
        </p>
        <datalist id="projects-there">
          {projects.value?.items.map((one) => (
            <option key={one} value={one} />
          ))}
        </datalist>
      </form>
    </Dialog>
  );
}

async function copied(ids: string[], project: string): Promise<void> {
  const { documents } = await ask("post", "/selections/copy", {
    body: { selection: { documents: ids, include_made: true, property: [] }, project },
  });
  library.refresh();
  note(w("label.copiedTo", { n: documents.length, name: project }), {
    action: { text: w("button.undo"), run: () => void remove(documents) },
  });
}

async function remove(documents: string[]): Promise<void> {
  try {
    const { items } = await ask("post", "/selections/delete", {
      body: { documents, include_made: true, property: [] },
    });
    note(w("label.deleted", { n: items.length }));
  } catch (error) {
    refuse(error);
  }
  library.refresh();
}

async function moved(ids: string[], project: string): Promise<void> {
  const before = new Map<string, string>();
  for (const id of ids)
    before.set(id, library.cardOf(id)?.project ?? (await get("/documents/{id}", { path: { id } })).project);
  const gone = await into(ids, project);
  if (!gone.length) {
    note(w("help.allThere", { name: project }));
    return;
  }
  // They may be no part of what the library shows now: what is done next must not be done to them unseen.
  library.picked.value = new Set();
  note(w("label.movedTo", { n: gone.length, name: project }), {
    action: { text: w("button.undo"), run: () => void takeBack(gone, before) },
  });
}

/** Those that were elsewhere. */
async function into(ids: string[], project: string): Promise<string[]> {
  const { items } = await ask("post", "/selections/change", {
    body: {
      selection: { documents: ids, include_made: true, property: [] },
      change: { project, message: "" },
      labels: [],
    },
  });
  library.refresh();
  return items.map((one) => one.id);
}

async function takeBack(gone: string[], before: Map<string, string>): Promise<void> {
  let done = 0;
  for (const project of new Set(gone.map((id) => before.get(id)!))) {
    try {
      done += (
        await into(
          gone.filter((id) => before.get(id) === project),
          project,
        )
      ).length;
    } catch (error) {
      refuse(error);
    }
  }
  if (done) note(w("label.movedBack", { n: done }));
}
