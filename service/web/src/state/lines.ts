/** The document's text in windows of frames: which lines of how many, and what of an edited window changed. */
import { address, fetched } from "../api/client";

export interface Window {
  text: string;
  /** From 1, in the whole document. */
  firstLine: number;
  totalLines: number;
  /** Frames of the window, from 1; null: the head. */
  frames: [number, number] | null;
}

export const FRAMES_AT_ONCE = 40;

export async function readWindow(id: string, revision: number, frames: [number, number] | null, signal: AbortSignal): Promise<Window> {
  const query = frames ? { part: "frames", first: frames[0], last: frames[1], revision } : { part: "head", revision };
  const answer = await fetched(address("/documents/{id}/mcml", { id }, { ...query, pretty: true }), { signal });
  const header = (name: string) => Number(answer.headers.get(`x-mcml-${name}`));
  return { text: await answer.text(), firstLine: header("first-line"), totalLines: header("total-lines"), frames };
}

export interface Replacement { address: string; fragment: string; line: number }

/** Frames of the window whose text is another now, each as one replacement. Error where frames were added or taken away
 * by text: that is done in the tree or the timeline. */
export function changedFrames(before: string, after: string, first: number): Replacement[] {
  const [old, now] = [frameTexts(before), frameTexts(after)];
  if (old.length !== now.length) throw new RangeError(`${old.length} ${now.length}`);
  return now.flatMap((one, index) => (one.text === old[index].text ? [] : [{ address: `/mcml/motion/frame[${first + index}]`, fragment: one.text, line: one.line }]));
}

function frameTexts(text: string): { text: string; line: number }[] {
  const found: { text: string; line: number }[] = [];
  const frame = /<frame\b[^>]*?(?:\/>|>[\s\S]*?<\/frame\s*>)/g;
  for (let match = frame.exec(text); match; match = frame.exec(text)) {
    found.push({ text: match[0], line: text.slice(0, match.index).split("\n").length });
  }
  return found;
}

/** Parts of the head (header, root, skeleton) whose text is another now. */
export function changedParts(before: string, after: string): Replacement[] {
  return ["header", "root", "skeleton"].flatMap((name) => {
    const part = new RegExp(`<${name}\\b[^>]*?(?:/>|>[\\s\\S]*</${name}\\s*>)`);
    const [old, now] = [part.exec(before)?.[0], part.exec(after)];
    return now && old !== undefined && now[0] !== old ? [{ address: `/mcml/${name}`, fragment: now[0], line: after.slice(0, now.index).split("\n").length }] : [];
  });
}
