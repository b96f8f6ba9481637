/** The document's text in windows of frames: which lines of how many, and what of an edited window changed. */
import { itemAt } from "../../lists";
import { address, fetched } from "../../api/client";

export interface Window {
  text: string;
  /** From 1, in the whole document. */
  firstLine: number;
  totalLines: number;
  /** Frames of the window, from 1; null: the head. */
  frames: [number, number] | null;
}

export const FRAMES_AT_ONCE = 40;

export async function readWindow(
  id: string,
  revision: number,
  frames: [number, number] | null,
  signal: AbortSignal,
): Promise<Window> {
  const query = frames ? { part: "frames", first: frames[0], last: frames[1], revision } : { part: "head", revision };
  const answer = await fetched(address("/documents/{id}/mcml", { id }, { ...query, pretty: true }), { signal });
  const header = (name: string) => Number(answer.headers.get(`x-mcml-${name}`));
  return { text: await answer.text(), firstLine: header("first-line"), totalLines: header("total-lines"), frames };
}

export interface Replacement {
  address: string;
  before: string;
  fragment: string;
  line: number;
}

/** Frames of the window whose text is another now, each as one replacement. RangeError where frames were added or taken
 * away, or something between them was changed: that is done in the tree or the timeline. */
export function changedFrames(before: string, after: string, first: number): Replacement[] {
  const [old, now] = [partsOf(before, ["frame"]), partsOf(after, ["frame"])];
  if (old.rest !== now.rest) throw new RangeError(`${old.parts.length} ${now.parts.length}`);
  return now.parts.flatMap((one, index) =>
    one.text === itemAt(old.parts, index).text
      ? []
      : [
          {
            address: `/mcml/motion/frame[${first + index}]`,
            before: itemAt(old.parts, index).text,
            fragment: one.text,
            line: one.line,
          },
        ],
  );
}

/** Parts of the head (header, root, skeleton) whose text is another now. RangeError where something beside them is. */
export function changedParts(before: string, after: string): Replacement[] {
  const names = ["header", "root", "skeleton"];
  const [old, now] = [partsOf(before, names), partsOf(after, names)];
  if (old.rest !== now.rest) throw new RangeError(names.join());
  return now.parts.flatMap((one, index) =>
    one.text === itemAt(old.parts, index).text
      ? []
      : [{ address: `/mcml/${one.name}`, before: itemAt(old.parts, index).text, fragment: one.text, line: one.line }],
  );
}

/** Elements of these names, none of which is inside another, and what is left of the text without them and white space. */
function partsOf(
  text: string,
  names: string[],
): { parts: { name: string; text: string; line: number }[]; rest: string } {
  const parts: { name: string; text: string; line: number }[] = [];
  const element = new RegExp(
    `<!--[^]*?-->|<(${names.join("|")})(?=[\\s/>])(?:"[^"]*"|'[^']*'|[^>"'])*?(?:/>|>[^]*?</\\1\\s*>)`,
    "g",
  );
  const rest = text.replace(element, (found, name: string | undefined, at: number) => {
    if (name === undefined) return found;
    parts.push({ name, text: found, line: text.slice(0, at).split("\n").length });
    return `<${name}/>`;
  });
  return { parts, rest: rest.replace(/\s+/g, " ").replace(/> </g, "><").trim() };
}

/** The samples of a frame's text that are others now; null where more than samples changed. Frames as from 1. */
export function changedSamples(before: string, after: string): Map<string, number> | null {
  const parsed = (text: string) => new DOMParser().parseFromString(text, "application/xml").documentElement;
  const [old, now] = [parsed(before), parsed(after)];
  const shape = (frame: Element) =>
    [...frame.children]
      .map(
        (one) =>
          `${one.tagName} ${one.tagName === "frame_bone" ? one.getAttributeNames().join(" ") + one.getAttribute("name") : one.textContent}`,
      )
      .join("|") +
    frame.getAttribute("id") +
    frame.children.length;
  if (now.querySelector("parsererror") || now.tagName === "parsererror" || shape(old) !== shape(now)) return null;
  const found = new Map<string, number>();
  for (const [index, bone] of [...now.children].entries()) {
    for (const name of bone.getAttributeNames()) {
      const [was, is] = [itemAt(old.children, index).getAttribute(name), bone.getAttribute(name)];
      if (was === is) continue;
      const value = Number(is);
      if (name === "name" || !is?.trim() || !Number.isFinite(value)) return null;
      found.set(`${bone.getAttribute("name")}.${name}`, value);
    }
  }
  return found;
}
