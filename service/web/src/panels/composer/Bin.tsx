/** Clips to take pieces from: search, drag, or press +. */
import { useState } from "preact/hooks";
import { Icon } from "../../ui/icons";
import { ThumbnailView } from "../../ui/ThumbnailView";
import { Trouble } from "../../ui/Trouble";
import { useClips } from "../../ui/useClips";
import { w } from "../../words";

export function Bin({ onAdd }: { onAdd: (document: string, name: string) => void }) {
  const [text, setText] = useState("");
  const [hovered, setHovered] = useState("");
  const clips = useClips(text);
  return (
    <>
      <input class="field" type="search" aria-label={w("search")} placeholder={w("search")} value={text} onInput={(event) => setText(event.currentTarget.value)} />
      <Trouble error={clips.error} retry={clips.again} />
      <ul class="bin-list">
        {(clips.value ?? []).map((one) => (
          <li key={one.id} draggable onPointerEnter={() => setHovered(one.id)} onPointerLeave={() => setHovered("")}
            onDragStart={(event) => event.dataTransfer?.setData("application/x-mcml-clip", JSON.stringify({ id: one.id, name: one.name }))}>
            <ThumbnailView thumbnail={one.thumb} runs={hovered === one.id} label={one.name} />
            <span class="grow"><span class="cut block">{one.name}</span><span class="dim">{one.time}</span></span>
            <button type="button" class="button quiet icon dense" aria-label={`${w("add")} ${one.name}`} onClick={() => onAdd(one.id, one.name)}><Icon name="plus" /></button>
          </li>
        ))}
      </ul>
    </>
  );
}
