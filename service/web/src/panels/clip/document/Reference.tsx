/** A video or a sound of the take, in step with the motion: while it sounds, the picture follows it. */
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { address, ask, fetched, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { note, refuse } from "../../../state/session/notes";
import { Icon } from "../../../ui/icons";
import { w } from "../../../words";

type Media = Schemas["MediaInfo"];
const APART = 0.06; // seconds that a picture at rest may be off before it is moved

export function Reference({ clip, media }: { clip: Clip; media: Media }) {
  const element = useRef<HTMLVideoElement & HTMLAudioElement>(null);
  const [open, setOpen] = useState(true);
  const { player } = clip;
  useEffect(() => {
    const one = element.current;
    if (!one || !open) return;
    const wanted = () => media.offset + player.frame.peek() / player.perSecond;
    player.lead = () =>
      one.paused || one.readyState < 3 || one.ended ? null : (one.currentTime - media.offset) * player.perSecond;
    const stops = [
      effect(() => {
        const speed = player.speed.value;
        // Media plays forwards alone, and not before its own beginning.
        if (player.playing.value && speed > 0 && wanted() >= 0) {
          one.currentTime = wanted();
          one.playbackRate = speed;
          void one.play().catch(() => undefined);
        } else one.pause();
      }),
      effect(() => {
        player.frame.value;
        if (one.paused && Math.abs(one.currentTime - wanted()) > APART) one.currentTime = Math.max(0, wanted());
        // The loop begins again: so does the sound.
        else if (!one.paused && Math.abs(one.currentTime - wanted()) > 0.5) one.currentTime = Math.max(0, wanted());
      }),
    ];
    return () => {
      for (const stop of stops) stop();
      player.lead = null;
      one.pause();
    };
  }, [clip, media, open]);
  const source = address("/documents/{id}/media", { id: clip.id });
  const label = w("label.referenceOf", { name: media.name });
  const isVideo = media.media_type.startsWith("video/");
  return (
    <div class={`reference ${open ? "" : "folded"}`}>
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={label}
        aria-expanded={open}
        onClick={() => setOpen(!open)}
      >
        <Icon name={open ? "down" : "play"} />
      </button>
      {open &&
        (isVideo ? (
          <video ref={element} src={source} preload="auto" playsInline aria-label={label} />
        ) : (
          <audio ref={element} src={source} preload="auto" aria-label={label} />
        ))}
      {!isVideo && <span class="cut dim">{media.name}</span>}
    </div>
  );
}

export function ReferenceForm({ clip, reload }: { clip: Clip; reload: () => void }) {
  const media = clip.detail.media;
  const choose = () => {
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
  };
  const change = async (offset: number) => {
    try {
      await ask("patch", "/documents/{id}/media", { path: { id: clip.id }, body: { offset } });
      reload();
    } catch (error) {
      refuse(error);
    }
  };
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
      <div>
        <p class="dim">{w("help.referenceHelp")}</p>
        <button type="button" class="button dense" onClick={choose}>
          {w("button.chooseMedia")}
        </button>
      </div>
    );
  return (
    <div class="row wrap">
      <span class="cut">{media.name}</span>
      <label class="row">
        <span class="dim">{w("label.beginsAt")}</span>
        <input
          class="field number"
          type="number"
          step="0.01"
          value={media.offset}
          onChange={(event) => void change(Number(event.currentTarget.value))}
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
