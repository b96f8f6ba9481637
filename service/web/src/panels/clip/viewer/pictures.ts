/** The viewer's picture as PNG, and a film of the loop as MP4, or as WebM where the browser records no MP4. */
import { signal } from "@preact/signals";
import type { Clip } from "../../../state/clip/clip";
import type { Stage } from "../../../scene/stage";
import { saveBlob } from "../../../ui/exporting/saveBlob";
import { note, refuse } from "../../../state/session/notes";
import { look } from "../../../state/session/settings";
import { r } from "../words";

export const filming = signal(false);
const BITS = 8_000_000;
/** Milliseconds until a recording must hold a picture, and from one look at it to the next. */
const PATIENCE = 5_000;
const AGAIN = 100;
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
    recorder.ondataavailable = (event) => event.data.size && parts.push(event.data);
    player.pause();
    player.seek(player.range[0]);
    filming.value = true;
    recorder.start();
    await playOnce(player);
    await endRecording(recorder, parts);
    if (parts.length) saveBlob(new Blob(parts, { type: film.type }), `${clip.detail.name}.${film.ending}`);
    else note(r("error.noPicture"), { bad: true });
  } catch (error) {
    refuse(error);
  } finally {
    filming.value = false;
  }
}

/** Plays until the loop has begun again, or somebody has stopped it. */
function playOnce(player: Clip["player"]): Promise<void> {
  const [first, last] = player.range;
  player.play(Math.abs(player.speed.peek()) || 1);
  let before = first;
  return new Promise((done) => {
    const stop = player.frame.subscribe((frame) => {
      if (frame < before || frame >= last || !player.playing.peek()) {
        stop();
        player.pause();
        done();
      }
      before = frame;
    });
  });
}

/** Ends a recording once it holds a picture, or after some seconds: encoders of busy machines begin late. */
async function endRecording(recorder: MediaRecorder, parts: Blob[]): Promise<void> {
  const end = performance.now() + PATIENCE;
  do {
    look.value = look.peek() + 1;
    await new Promise((done) => setTimeout(done, AGAIN));
    recorder.requestData();
  } while (!parts.length && performance.now() < end);
  await new Promise((done) => {
    recorder.onstop = done;
    recorder.stop();
  });
}
