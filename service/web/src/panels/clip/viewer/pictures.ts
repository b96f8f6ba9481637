/** The viewer's picture as PNG, and a film of the loop as MP4, or as WebM where the browser records no MP4. */
import { signal } from "@preact/signals";
import type { Clip } from "../../../state/clip/clip";
import type { Stage } from "../../../scene/stage";
import { saveBlob } from "../../../ui/exporting/saveBlob";
import { refuse } from "../../../state/session/notes";

export const filming = signal(false);
const BITS = 8_000_000;
const FILMS = [
  { type: "video/mp4;codecs=avc1.640028", name: "MP4", ending: "mp4" },
  { type: "video/webm", name: "WebM", ending: "webm" },
] as const;

/** The form in which this browser records. */
export const filmOf = () => FILMS.find(({ type }) => MediaRecorder.isTypeSupported(type)) ?? FILMS[1];

export async function savePicture(stage: Stage, clip: Clip): Promise<void> {
  saveBlob(await stage.picture(), `${clip.detail.name} frame ${clip.player.frame.peek() + 1}.png`);
}

/** Plays the loop once and records it. */
export async function saveFilm(stage: Stage, clip: Clip): Promise<void> {
  const { player } = clip;
  try {
    const film = filmOf();
    const recorder = new MediaRecorder(stage.canvas.captureStream(60), {
      mimeType: film.type,
      videoBitsPerSecond: BITS,
    });
    const parts: Blob[] = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => saveBlob(new Blob(parts, { type: film.type }), `${clip.detail.name}.${film.ending}`);
    const [first, last] = player.range;
    player.pause();
    player.seek(first);
    filming.value = true;
    recorder.start();
    player.play(Math.abs(player.speed.peek()) || 1);
    let before = first;
    const stop = player.frame.subscribe((frame) => {
      // The loop has begun again, or somebody stopped it.
      if (frame < before || frame >= last || !player.playing.peek()) {
        stop();
        player.pause();
        setTimeout(() => recorder.stop(), 100);
        filming.value = false;
      }
      before = frame;
    });
  } catch (error) {
    filming.value = false;
    refuse(error);
  }
}
