/** Files over the window cover it with what will happen to them. */
import { useEffect, useState } from "preact/hooks";
import { filesOf } from "../state/importing/dropped";
import { addFiles } from "../state/importing/uploads";
import { dropHere, dropOnto } from "../state/importing/drop";
import { lookFirst } from "../state/importing/inspect";
import { Icon } from "../ui/icons";
import { w } from "../words";

type Field = "add" | "look" | "onto";

/** The field under the pointer. */
function fieldAt(event: DragEvent): Field {
  const field = (event.target as Element).closest<HTMLElement>("[data-drop]")?.dataset.drop;
  return field === "look" || field === "onto" ? field : "add";
}

export function DropTarget() {
  const [over, setOver] = useState<"" | Field>("");
  useEffect(() => {
    let depth = 0;
    const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
    const enter = (event: DragEvent) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      depth++;
      setOver((now) => now || "add");
    };
    const leave = (event: DragEvent) => {
      if (hasFiles(event) && --depth <= 0) {
        depth = 0;
        setOver("");
      }
    };
    const drag = (event: DragEvent) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      setOver(fieldAt(event));
    };
    const drop = async (event: DragEvent) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      const field = fieldAt(event);
      depth = 0;
      setOver("");
      const { files, missed } = await filesOf(event.dataTransfer!);
      if (dropHere.value) dropHere.value.take(files);
      else if (field === "onto" && dropOnto.value) dropOnto.value.take(files);
      else if (field === "look") void lookFirst(files, missed);
      else addFiles(files, missed);
    };
    const escape = (event: KeyboardEvent) => event.key === "Escape" && setOver("");
    addEventListener("dragenter", enter);
    addEventListener("dragleave", leave);
    addEventListener("dragover", drag);
    addEventListener("drop", drop);
    addEventListener("keydown", escape);
    return () => {
      removeEventListener("dragenter", enter);
      removeEventListener("dragleave", leave);
      removeEventListener("dragover", drag);
      removeEventListener("drop", drop);
      removeEventListener("keydown", escape);
    };
  }, []);
  if (!over) return null;
  const own = dropHere.value;
  if (own)
    return (
      <section class="drop-cover alone" aria-label={own.title}>
        <div class="drop-field over">
          <Icon name="upload" />
          <h2>{own.title}</h2>
          <p>{own.help}</p>
        </div>
      </section>
    );
  const onto = dropOnto.value;
  return (
    <section class={`drop-cover ${onto ? "three" : ""}`} aria-label={w("label.dropTitle")}>
      <div class={`drop-field ${over === "add" ? "over" : ""}`} data-drop="add">
        <Icon name="upload" />
        <h2>{w("label.dropTitle")}</h2>
        <p>{w("help.dropHelp")}</p>
      </div>
      {onto && (
        <div class={`drop-field ${over === "onto" ? "over" : ""}`} data-drop="onto">
          <Icon name="retarget" />
          <h2>{onto.title}</h2>
          <p>{onto.help}</p>
        </div>
      )}
      <div class={`drop-field ${over === "look" ? "over" : ""}`} data-drop="look">
        <Icon name="eye" />
        <h2>{w("button.lookFirst")}</h2>
        <p>{w("help.lookFirstHelp")}</p>
      </div>
    </section>
  );
}
