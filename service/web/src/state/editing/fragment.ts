/** Changes made within an element that is already replaced by a text of the same draft: they go into that text. */

export interface Within {
  attributes?: Record<string, string | null>;
  text?: string;
}

const parsed = (fragment: string): Element | null => {
  const root = new DOMParser().parseFromString(fragment, "application/xml").documentElement;
  return !root || root.tagName === "parsererror" || root.querySelector("parsererror") ? null : root;
};

/** The element at the end of steps such as `bone[2]/position` below a root; "" is the root. */
function elementAt(root: Element, steps: string): Element | null {
  let here: Element | null = root;
  for (const step of steps.split("/").filter(Boolean)) {
    const [, tag, place] = /^([^[]+)(?:\[(\d+)\])?$/.exec(step) ?? [];
    if (!tag || !here) return null;
    here = [...here.children].filter((one) => one.tagName === tag)[Number(place ?? 1) - 1] ?? null;
  }
  return here;
}

function changed(fragment: string, change: (root: Element) => boolean): string | null {
  const root = parsed(fragment);
  return root && change(root) ? new XMLSerializer().serializeToString(root) : null;
}

/** The text with attributes and text of one of its elements changed; null where it has no such element. */
export const changedWithin = (fragment: string, steps: string, { attributes = {}, text }: Within): string | null =>
  changed(fragment, (root) => {
    const element = elementAt(root, steps);
    if (!element || (text !== undefined && element.children.length)) return false;
    for (const [name, value] of Object.entries(attributes)) {
      if (value === null) element.removeAttribute(name);
      else element.setAttribute(name, value);
    }
    if (text !== undefined) element.textContent = text;
    return true;
  });

/** What an attribute or the text is within a text; null where it is not there. */
export function readWithin(fragment: string, steps: string, attribute: string | null): string | null {
  const root = parsed(fragment);
  const element = root && elementAt(root, steps);
  return element ? (attribute === null ? element.textContent : element.getAttribute(attribute)) : null;
}

/** A frame's text with one sample changed; null where it has no such bone. */
export const sampleWithin = (frame: string, bone: string, channel: string, value: number): string | null =>
  changed(frame, (root) => {
    const found = [...root.children].find((one) => one.tagName === "frame_bone" && one.getAttribute("name") === bone);
    found?.setAttribute(channel, String(value));
    return Boolean(found);
  });

/** A frame's text with motion names taken away and put in; null where it cannot be read. */
export const namesWithin = (frame: string, gone: readonly string[], come: readonly string[]): string | null =>
  changed(frame, (root) => {
    const names = [...root.children].filter((one) => one.tagName === "motion_name");
    for (const one of names) if (gone.includes(one.textContent ?? "")) one.remove();
    const bones = [...root.children].find((one) => one.tagName !== "motion_name") ?? null;
    for (const name of come) {
      if (names.some((one) => one.parentNode && one.textContent === name)) continue;
      const made = root.ownerDocument.createElementNS(root.namespaceURI, "motion_name");
      made.textContent = name;
      root.insertBefore(made, bones);
    }
    return true;
  });

/** A sample as a frame's text says it, "Root.Tx"; null where it does not. */
export function sampleIn(frame: string, track: string): string | null {
  const at = track.lastIndexOf(".");
  return (
    [...(parsed(frame)?.children ?? [])]
      .find((one) => one.getAttribute("name") === track.slice(0, at))
      ?.getAttribute(track.slice(at + 1)) ?? null
  );
}
