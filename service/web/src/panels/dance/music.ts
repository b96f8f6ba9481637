/** A piece of music: its beats as the server found them, its sound and outline as the browser reads it. */
import { numberAt } from "../../lists";
import { address, fetched, get, type Schemas } from "../../api/client";
import { peaksOf } from "../../motion/dance/peaks";

const MOST_DECODED = 5 * 60; // seconds; what is longer plays from the file
const PEAKS = 4000;

export interface Music {
  file: File;
  seconds: number;
  /** null: too long to be decoded, or no sound that the browser knows. */
  buffer: AudioBuffer | null;
  /** Of the file, where it is too long. */
  address: string | null;
  peaks: Float32Array | null;
  beats: number[];
  bpm: number;
  even: boolean;
  /** Which beat, from 1, the first bar starts on. */
  downbeat: number;
  factor: "1/2" | "1" | "2";
  beatsPerBar: number;
  /** Tempi that it may have, with their strength, the one taken first; none of music that was kept. */
  rivals: Schemas["TempoRival"][];
  /** Whether the tempo taken fits clearly better than its rivals, or was chosen. */
  clear: boolean;
  readonly wish: Schemas["Music"];
}

export function withChoice(music: Music, choice: Partial<Pick<Music, "downbeat" | "factor" | "beatsPerBar">>): Music {
  const next = { ...music, ...choice };
  return {
    ...next,
    wish: { beats: next.beats, downbeat: next.downbeat, factor: next.factor, beats_per_bar: next.beatsPerBar },
  };
}

/** Beats by the server, sound by the browser. bpm: one of the rivals. ApiError for what holds no beats. */
export async function readMusic(file: File, bpm?: number): Promise<Music> {
  const form = new FormData();
  form.append("file", file, file.name);
  if (bpm) form.append("bpm", String(bpm));
  const found = (await (
    await fetched("/api/v1/music", { method: "POST", body: form })
  ).json()) as Schemas["MusicBeats"];
  return { ...(await soundOf(file, found.music, found.bpm, found.even)), rivals: found.rivals, clear: found.clear };
}

/** The music that was kept with a dance, and the second of it at which the dance begins; null where there is none. */
export async function keptMusic(
  document: string,
  given: Schemas["Music"],
  signal: AbortSignal,
): Promise<{ music: Music; offset: number } | null> {
  const { media } = await get("/documents/{id}", { path: { id: document }, signal });
  if (!media?.media_type.startsWith("audio/")) return null;
  const bytes = await (await fetched(address("/documents/{id}/media", { id: document }), { signal })).blob();
  const steps = given.beats
    .slice(1)
    .map((at, index) => at - numberAt(given.beats, index))
    .sort((a, b) => a - b);
  const file = new File([bytes], media.name, { type: media.media_type });
  return { music: await soundOf(file, given, 60 / (steps[steps.length >> 1] || 0.5), true), offset: media.offset };
}

async function soundOf(file: File, given: Schemas["Music"], bpm: number, even: boolean): Promise<Music> {
  const source = URL.createObjectURL(file);
  const seconds = await lengthOf(source);
  const buffer = seconds > MOST_DECODED ? null : await decoded(file);
  const plays = !buffer && Number.isFinite(seconds);
  if (!plays) URL.revokeObjectURL(source);
  const { beats, downbeat, factor, beats_per_bar: beatsPerBar } = given;
  return {
    file,
    buffer,
    beats,
    downbeat,
    factor,
    beatsPerBar,
    rivals: [],
    clear: true,
    bpm,
    even,
    wish: given,
    seconds: buffer?.duration ?? (plays ? seconds : (beats.at(-1) ?? 0)),
    address: plays ? source : null,
    peaks: buffer ? peaksOf(buffer.getChannelData(0), PEAKS) : null,
  };
}

async function decoded(file: File): Promise<AudioBuffer | null> {
  try {
    // An offline context decodes without asking for a device.
    return await new OfflineAudioContext(2, 1, 48_000).decodeAudioData(await file.arrayBuffer());
  } catch {
    return null;
  }
}

/** Seconds of a sound; not finite where the browser cannot tell. */
const lengthOf = (address: string): Promise<number> =>
  new Promise((resolve) => {
    const element = new Audio();
    element.preload = "metadata";
    element.onloadedmetadata = () => resolve(element.duration);
    element.onerror = () => resolve(Number.NaN);
    element.src = address;
  });
