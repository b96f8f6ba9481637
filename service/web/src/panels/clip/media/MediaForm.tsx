/** The file that is attached as reference media: choose it, set where the motion begins in it, remove it. */
import { address, ask, fetched } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { Icon } from "../../../ui/icons";
import { w } from "../../../words";

/** Set the seconds in the media at the first frame. */
export async function changeOffset(clip: Clip, offset: number, reload: () => void): Promise<void> {
  try {
    await ask("patch", "/documents/{id}/media", { path: { id: clip.id }, body: { offset } });
    reload();
  } catch (error) {
    refuse(error);
  }
}

function chooseFile(clip: Clip, reload: () => void): void {
  const input = document.createElement("input");
  input.type = "file";
  input.accept = "video/*,audio/*";
  input.onchange = async () => {
    const file = input.files?.[0];
    if (!file) return;
    const form = new FormData();
    form.append("file", file, file.name);
    try {
      await fetched(address("/documents/{id}/media", { id: clip.id }), { method: "PUT", body: form });
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  input.click();
}

export function MediaForm({ clip, reload }: { clip: Clip; reload: () => void }) {
  const media = clip.detail.media;
  const remove = async () => {
    try {
      await ask("delete", "/documents/{id}/media", { path: { id: clip.id } });
      note(w("label.mediaGone"));
      reload();
    } catch (error) {
      refuse(error);
    }
  };
  if (!media)
    return (
      <div class="media-none">
        <p class="dim">{w("help.referenceHelp")}</p>
        <button type="button" class="button" onClick={() => chooseFile(clip, reload)}>
          {w("button.chooseMedia")}
        </button>
      </div>
    );
  return (
    <div class="row wrap">
      <span class="cut grow" title={media.name}>
        {media.name}
      </span>
      <label class="row">
        <span class="dim">{w("label.beginsAt")}</span>
        <input
          key={media.offset}
          class="field number"
          type="number"
          step="0.01"
          value={Number(media.offset.toFixed(3))}
          onChange={(event) => void changeOffset(clip, Number(event.currentTarget.value), reload)}
        />{" "}
        s
      </label>
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={`${w("button.remove")} ${media.name}`}
        onClick={() => void remove()}
      >
        <Icon name="close" />
      </button>
    </div>
  );
}
