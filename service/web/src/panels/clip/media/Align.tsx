/** Where the motion begins in a video or sound, by two clicks: a moment of the media, and the same one of the motion. */
import type { RefObject } from "preact";
import { useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import { note } from "../../../state/session/notes";
import { number, w } from "../../../words";
import { v } from "../words";
import { offsetOf } from "./drawing";
import type { Media, MediaElement } from "./InStep";
import { changeOffset } from "./MediaForm";

/** What is being looked for: nothing, a moment of the media, or the frame of the motion that shows it. */
export type Aligning = null | "media" | { moment: number };

export function Align(props: {
  clip: Clip;
  media: Media;
  element: RefObject<MediaElement | null>;
  state: Aligning;
  onState: (state: Aligning) => void;
  reload: () => void;
}) {
  const { clip, media, element, state, onState, reload } = props;
  const [moment, setMoment] = useState(0);
  const step = (seconds: number) => {
    const one = element.current;
    if (!one) return;
    one.pause();
    one.currentTime = Math.max(0, one.currentTime + seconds);
    setMoment(one.currentTime);
  };
  const finish = async (at: number) => {
    const before = media.offset;
    const offset = offsetOf(at, clip.player.frame.peek(), clip.player.perSecond);
    onState(null);
    await changeOffset(clip, offset, reload);
    note(v("label.aligned", { seconds: number(offset, 2) }), {
      action: { text: w("button.undo"), run: () => void changeOffset(clip, before, reload) },
    });
  };
  if (state === null)
    return (
      <button
        type="button"
        class="button dense"
        title={v("help.align")}
        onClick={() => {
          clip.player.pause();
          onState("media");
        }}
      >
        {v("button.align")}
      </button>
    );
  return (
    <div class="align" role="group" aria-label={v("button.align")}>
      {state === "media" ? (
        <>
          <p>{v("help.findMoment")}</p>
          <div class="row wrap">
            <button type="button" class="button dense" onClick={() => step(-1 / 30)}>
              {v("button.earlier")}
            </button>
            <button type="button" class="button dense" onClick={() => step(1 / 30)}>
              {v("button.later")}
            </button>
            <button
              type="button"
              class="button primary dense"
              onClick={() => {
                const at = element.current?.currentTime ?? moment;
                element.current?.pause();
                onState({ moment: at });
              }}
            >
              {v("button.useMoment")}
            </button>
          </div>
        </>
      ) : (
        <>
          <p>{v("help.findFrame", { seconds: number(state.moment, 2) })}</p>
          <div class="row wrap">
            <button type="button" class="button primary dense" onClick={() => void finish(state.moment)}>
              {v("button.useFrame", { frame: clip.player.frame.value + 1 })}
            </button>
          </div>
        </>
      )}
      <button type="button" class="button quiet dense" onClick={() => onState(null)}>
        {w("button.cancel")}
      </button>
    </div>
  );
}
