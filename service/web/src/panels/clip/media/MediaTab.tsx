/** The video or sound of the clip, large: aligned with the motion, and measured by drawing on its picture. */
import { useRef, useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import { Icon } from "../../../ui/icons";
import { number, w } from "../../../words";
import { v } from "../words";
import { Align, type Aligning } from "./Align";
import { angleText, DrawingLayer } from "./DrawingLayer";
import { drawingIn, lengthOf, SAME_PICTURE, type Drawing, type Kind } from "./drawing";
import { isVideo, MediaView, type Media, type MediaElement } from "./InStep";
import { MediaForm } from "./MediaForm";

/** Kept while the page is open, by document. */
interface Drawn {
  drawings: readonly Drawing[];
  /** Metres of a pixel, where a length is known. */
  scale: number | null;
}
const drawn = new Map<string, Drawn>();
let last = 0;

export function MediaTab({ clip, reload }: { clip: Clip; reload: () => void }) {
  const media = clip.detail.media;
  return (
    <div class="media-tab">
      {media && <MediaTools key={media.sha256} clip={clip} media={media} reload={reload} />}
      <MediaForm clip={clip} reload={reload} />
    </div>
  );
}

function MediaTools({ clip, media, reload }: { clip: Clip; media: Media; reload: () => void }) {
  const element = useRef<MediaElement>(null);
  const [[width, height], setSize] = useState<[number, number]>([0, 0]);
  const [time, setTime] = useState(0);
  const [aligning, setAligning] = useState<Aligning>(null);
  const [{ drawings, scale }, setDrawn] = useState<Drawn>(drawn.get(clip.id) ?? { drawings: [], scale: null });
  const change = (next: Partial<Drawn>) => {
    const all = { drawings, scale, ...next };
    drawn.set(clip.id, all);
    setDrawn(all);
  };
  const textOf = (one: Drawing) => (one.kind === "angle" ? angleText(one) : lengthText(one, scale));
  const add = (kind: Kind) => {
    clip.player.pause();
    const at = element.current?.currentTime ?? 0;
    setTime(at);
    change({ drawings: [...drawings, drawingIn(kind, ++last, width, height, at)] });
  };
  const replace = (one: Drawing) => change({ drawings: drawings.map((other) => (other.id === one.id ? one : other)) });
  return (
    <>
      <div class="media-picture">
        <MediaView
          clip={clip}
          media={media}
          element={element}
          free={aligning === "media"}
          onSize={(...size) => setSize(size)}
          onTime={setTime}
        />
        {width > 0 && aligning === null && (
          <DrawingLayer
            drawings={drawings.filter((one) => Math.abs(one.time - time) <= SAME_PICTURE)}
            width={width}
            height={height}
            textOf={textOf}
            onChange={replace}
          />
        )}
      </div>
      <div class="row wrap">
        <Align clip={clip} media={media} element={element} state={aligning} onState={setAligning} reload={reload} />
        {isVideo(media) && aligning === null && (
          <>
            <button type="button" class="button dense" disabled={!width} onClick={() => add("angle")}>
              {v("button.measureAngle")}
            </button>
            <button type="button" class="button dense" disabled={!width} onClick={() => add("length")}>
              {v("button.measureLength")}
            </button>
          </>
        )}
      </div>
      {drawings.length > 0 && (
        <DrawingList
          drawings={drawings}
          scale={scale}
          textOf={textOf}
          onGo={(one) => clip.player.seek((one.time - media.offset) * clip.player.perSecond)}
          onChange={change}
        />
      )}
    </>
  );
}

const lengthText = (one: Drawing, scale: number | null): string => {
  const pixels = lengthOf(one.points);
  return scale === null ? `${number(pixels, 0)} px` : `${number(pixels * scale, 3)} m`;
};

function DrawingList(props: {
  drawings: readonly Drawing[];
  scale: number | null;
  textOf: (one: Drawing) => string;
  onGo: (one: Drawing) => void;
  onChange: (next: Partial<Drawn>) => void;
}) {
  const { drawings, scale, textOf, onGo, onChange } = props;
  return (
    <>
      <ol class="drawing-list">
        {drawings.map((one) => (
          <li key={one.id} class="row">
            <button type="button" class="button quiet dense" onClick={() => onGo(one)}>
              {v("button.goTo", { seconds: number(one.time, 2) })}
            </button>
            <span class="grow">
              {v(`label.${one.kind}`)} {textOf(one)}
            </span>
            {one.kind === "length" && (
              <label class="row">
                <span class="dim">{v("label.knownLength")}</span>
                <input
                  class="field number"
                  type="number"
                  min="0"
                  step="0.01"
                  onChange={(event) => {
                    const metres = Number(event.currentTarget.value);
                    const pixels = lengthOf(one.points);
                    if (metres > 0 && pixels > 0) onChange({ scale: metres / pixels });
                  }}
                />{" "}
                m
              </label>
            )}
            <button
              type="button"
              class="button quiet icon dense"
              aria-label={`${w("button.remove")} ${v(`label.${one.kind}`)} ${textOf(one)}`}
              onClick={() => onChange({ drawings: drawings.filter((other) => other.id !== one.id) })}
            >
              <Icon name="close" />
            </button>
          </li>
        ))}
      </ol>
      <p class="dim">{v(scale === null ? "help.drawings" : "help.drawingsScaled")}</p>
    </>
  );
}
