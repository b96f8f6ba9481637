/** The video or sound of a clip, in step with the motion: while it plays, the motion follows it. */
import { effect } from "@preact/signals";
import type { RefObject } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { address, type Schemas } from "../../../api/client";
import type { Clip } from "../../../state/clip/clip";
import { param, setParams } from "../../../state/session/route";
import { Icon } from "../../../ui/icons";
import { w } from "../../../words";
import { v } from "../words";

export type Media = Schemas["MediaInfo"];
export type MediaElement = HTMLVideoElement & HTMLAudioElement;
const APART = 0.06; // seconds that a picture at rest may be off before it is moved

export const isVideo = (media: Media): boolean => media.media_type.startsWith("video/");

/** Keep an element in step with the clip's player until the answer is called. */
function keepInStep(one: MediaElement, clip: Clip, offset: number): () => void {
  const { player } = clip;
  const wanted = () => offset + player.frame.peek() / player.perSecond;
  player.lead = () =>
    one.paused || one.readyState < 3 || one.ended ? null : (one.currentTime - offset) * player.perSecond;
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
}

/** The element, in step unless it is free. */
export function MediaView(props: {
  clip: Clip;
  media: Media;
  element: RefObject<MediaElement | null>;
  free?: boolean;
  onSize?: (width: number, height: number) => void;
  onTime?: (seconds: number) => void;
}) {
  const { clip, media, element, free = false, onSize, onTime } = props;
  useEffect(() => {
    if (element.current && !free) return keepInStep(element.current, clip, media.offset);
    return undefined;
  }, [clip, media.offset, free, element]);
  const source = address("/documents/{id}/media", { id: clip.id });
  const label = w("label.referenceOf", { name: media.name });
  const tell = () => onTime?.(element.current?.currentTime ?? 0);
  return isVideo(media) ? (
    <video
      ref={element}
      src={source}
      preload="auto"
      playsInline
      controls={free}
      aria-label={label}
      onLoadedMetadata={(event) => onSize?.(event.currentTarget.videoWidth, event.currentTarget.videoHeight)}
      onSeeked={tell}
      onTimeUpdate={tell}
    />
  ) : (
    <audio ref={element} src={source} preload="auto" controls={free} aria-label={label} onTimeUpdate={tell} />
  );
}

/** In a corner of the viewer, unless its own tab shows it. */
export function Reference({ clip, media }: { clip: Clip; media: Media }) {
  const element = useRef<MediaElement>(null);
  const [open, setOpen] = useState(true);
  if (param("tab") === "video") return null;
  return (
    <div class={`reference ${open ? "" : "folded"}`}>
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={w("label.referenceOf", { name: media.name })}
        aria-expanded={open}
        onClick={() => setOpen(!open)}
      >
        <Icon name={open ? "down" : "play"} />
      </button>
      {open && <MediaView clip={clip} media={media} element={element} />}
      <button
        type="button"
        class="button quiet icon dense"
        aria-label={v("button.openVideo")}
        title={v("button.openVideo")}
        onClick={() => setParams({ tab: "video" })}
      >
        <Icon name="right" />
      </button>
      {!isVideo(media) && <span class="cut dim">{media.name}</span>}
    </div>
  );
}
