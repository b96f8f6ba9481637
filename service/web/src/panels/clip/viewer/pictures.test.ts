// @vitest-environment happy-dom
import { signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Stage } from "../../../scene/stage";
import type { Clip } from "../../../state/clip/clip";
import { notes } from "../../../state/session/notes";
import { filming, saveFilm } from "./pictures";

/** The files that the browser was given to keep. */
let saved: { name: string; size: number }[] = [];

/** Empty data at first, as of an encoder that has not begun. */
class LateRecorder {
  static empty = 0;
  static isTypeSupported = (type: string) => type === "video/webm";
  ondataavailable: (event: { data: Blob }) => void = () => undefined;
  onstop: () => void = () => undefined;
  start() {}
  requestData() {
    this.ondataavailable({ data: new Blob(LateRecorder.empty-- > 0 ? [] : ["picture"]) });
  }
  stop() {
    this.ondataavailable({ data: new Blob([]) });
    this.onstop();
  }
}

const stage = { canvas: { captureStream: () => ({}) } } as unknown as Stage;

function makeClip(): Clip {
  const frame = signal(10);
  const player = {
    range: [10, 12],
    speed: signal(1),
    playing: signal(true),
    frame,
    pause: vi.fn(),
    seek: vi.fn(),
    play: () => queueMicrotask(() => (frame.value = 12)),
  };
  return { player, detail: { name: "walk" } } as unknown as Clip;
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("MediaRecorder", LateRecorder);
  notes.value = [];
  saved = [];
  let size = 0;
  vi.spyOn(URL, "createObjectURL").mockImplementation((blob) => {
    size = (blob as Blob).size;
    return "blob:saved";
  });
  vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(function (this: HTMLAnchorElement) {
    saved.push({ name: this.download, size });
  });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

describe("a video of the loop", () => {
  it("waits for its first picture", async () => {
    LateRecorder.empty = 3;
    const done = saveFilm(stage, makeClip());
    await vi.advanceTimersByTimeAsync(6_000);
    await done;
    expect(saved).toEqual([{ name: "walk.webm", size: "picture".length }]);
    expect(filming.value).toBe(false);
  });

  it("is not saved without a picture, and this is told", async () => {
    LateRecorder.empty = Infinity;
    const done = saveFilm(stage, makeClip());
    await vi.advanceTimersByTimeAsync(6_000);
    await done;
    expect(saved).toEqual([]);
    expect(notes.value.map((one) => one.text)).toEqual([
      "The browser recorded no picture. Try again, or use a longer loop.",
    ]);
  });
});
