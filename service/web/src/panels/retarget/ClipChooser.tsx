/** Choose one clip by its name and its moving picture. */
import { useState } from "preact/hooks";
import { useClips } from "../../ui/useClips";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { ThumbnailView } from "../../ui/ThumbnailView";
import { Trouble } from "../../ui/Trouble";
import { w } from "../../words";

export function ClipChooser({ label, chosen, onChoose }: { label: string; chosen: string | undefined; onChoose: (id: string) => void }) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <button type="button" class="button" onClick={() => setOpen(true)}><span class="dim">{label}:</span> <strong>{chosen ?? w("choose")}</strong><Icon name="down" /></button>
      {open && <Chooser title={label} onClose={() => setOpen(false)} onChoose={(id) => { setOpen(false); onChoose(id); }} />}
    </>
  );
}

function Chooser({ title, onClose, onChoose }: { title: string; onClose: () => void; onChoose: (id: string) => void }) {
  const [text, setText] = useState("");
  const [hovered, setHovered] = useState("");
  const clips = useClips(text);
  return (
    <Dialog title={title} onClose={onClose} wide>
      <input class="field chooser-search" type="search" autoFocus aria-label={w("search")} placeholder={w("search")} value={text} onInput={(event) => setText(event.currentTarget.value)} />
      <Trouble error={clips.error} retry={clips.again} />
      <div class="chooser">
        {(clips.value ?? []).map((one) => (
          <button key={one.id} type="button" class="chooser-card" onPointerEnter={() => setHovered(one.id)} onFocus={() => setHovered(one.id)} onClick={() => onChoose(one.id)}>
            <ThumbnailView thumbnail={one.thumb} runs={hovered === one.id} label={one.name} /><span class="cut block">{one.name}</span>
          </button>
        ))}
      </div>
    </Dialog>
  );
}
