/** Files that are shown without being stored. */
import type { Schemas } from "../../../api/client";
import type { Told } from "../../../motion/loading/preview";
import { looked, type Looked } from "../../../state/importing/inspect";
import { addFiles } from "../../../state/importing/uploads";
import { Dialog } from "../../../ui/Dialog";
import { lazy } from "../../../ui/lazy";
import { w } from "../../../words";
import { ReceiptView } from "./ReceiptView";
import { Refusal } from "./Refusal";

type Receipt = Schemas["Receipt"];

const LookedMotion = lazy(async () => (await import("./LookedMotion")).LookedMotion);

export function InspectedFiles({ of: { files, result } }: { of: Looked }) {
  return (
    <Dialog title={w("button.lookedAt")} onClose={() => (looked.value = null)} wide>
      {(result.clips as { files: string[]; receipt: Receipt; motion?: Told | null }[]).map((clip, index) => (
        <section key={index}>
          <h3>{clip.files.join(" + ")}</h3>
          {clip.motion && <LookedMotion told={clip.motion} />}
          <ReceiptView receipt={clip.receipt} documents={[]} />
        </section>
      ))}
      {result.problems.map((refused, at) => (
        <section key={at}>
          <h3>{refused.file}</h3>
          <Refusal refused={refused} />
        </section>
      ))}
      <p class="row">
        {files.length > 0 && (
          <button
            type="button"
            class="button primary"
            onClick={() => {
              looked.value = null;
              addFiles(files);
            }}
          >
            {w("button.keep")}
          </button>
        )}
        <span class="dim">{w("label.notStored")}</span>
      </p>
    </Dialog>
  );
}
