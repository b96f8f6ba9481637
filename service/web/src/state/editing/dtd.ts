/** What may stand where, read from mcml.dtd: for completion in the text, and for elements that are put into the tree. */
import type { ElementSpec } from "@codemirror/lang-xml";

export interface Attribute {
  name: string;
  values?: string[];
  required: boolean;
}

/** A child's place in its parent: how far on, whether it must be there, whether it may be there more than once. */
export interface Particle {
  name: string;
  rank: number;
  required: boolean;
  many: boolean;
}

export interface Kind {
  name: string;
  children: Particle[];
  attributes: Attribute[];
  text: boolean;
}

export type Dtd = ReadonlyMap<string, Kind>;

/** mcml.dtd's elements. Content models are sequences of names and of choices among names. */
export function readDtd(dtd: string): Dtd {
  const text = dtd.replace(/<!--[\s\S]*?-->/g, "");
  const attributes = new Map<string, Attribute[]>();
  for (const [, element = "", body = ""] of text.matchAll(/<!ATTLIST\s+(\S+)([\s\S]*?)>/g)) {
    const found = attributes.get(element) ?? [];
    for (const [, name = "", type = "", default_] of body.matchAll(
      /(\S+)\s+(CDATA|NMTOKENS?|IDREFS?|ID|\([^)]*\))\s+(#REQUIRED|#IMPLIED|#FIXED\s+"[^"]*"|"[^"]*")/g,
    )) {
      const required = default_ === "#REQUIRED";
      found.push(
        type.startsWith("(")
          ? {
              name,
              values: type
                .slice(1, -1)
                .split("|")
                .map((one) => one.trim()),
              required,
            }
          : { name, required },
      );
    }
    attributes.set(element, found);
  }
  return new Map(
    [...text.matchAll(/<!ELEMENT\s+(\S+)\s+([\s\S]*?)>/g)].map(([, name = "", model = ""]): [string, Kind] => [
      name,
      { name, children: particles(model), attributes: attributes.get(name) ?? [], text: model.includes("#PCDATA") },
    ]),
  );
}

function particles(model: string): Particle[] {
  const parts = [
    ...model
      .trim()
      .replace(/^\(([\s\S]*)\)([*+?]?)$/, (_, inner: string, times: string) =>
        times && !inner.includes(",") ? `(${inner})${times}` : inner,
      )
      .matchAll(/\(([^()]*)\)\s*([*+?]?)|([A-Za-z_][\w.-]*)([*+?]?)/g),
  ];
  return parts.flatMap(([, choice = "", choiceTimes, single, times], rank) => {
    const [names, how] = single ? [[single], times] : [choice.split("|").map((one) => one.trim()), choiceTimes];
    const known = names.filter((name) => !/^(EMPTY|ANY|#?PCDATA)$/.test(name));
    return known.map((name) => ({
      name,
      rank,
      required: names.length === 1 && (how === "" || how === "+"),
      many: how === "*" || how === "+",
    }));
  });
}

/** The same, as the editor's completion wants it. */
export const completions = (dtd: Dtd): ElementSpec[] =>
  [...dtd.values()].map(({ name, children, attributes }) => ({
    name,
    top: name === "mcml",
    children: [...new Set(children.map((child) => child.name))],
    attributes: attributes.map(({ name: attribute, values }) =>
      values ? { name: attribute, values } : { name: attribute },
    ),
  }));

/** What can be put into an element that has these children: what may stand more than once, or does not stand yet. */
export const addable = (kind: Kind, present: readonly string[]): string[] => [
  ...new Set(kind.children.filter((child) => child.many || !present.includes(child.name)).map((child) => child.name)),
];

/** Where a new child belongs among those that are there, in their order: behind the last that comes before it or is alike.
 * after: its index; -1: before the first. */
export function placeOf(kind: Kind, present: readonly string[], name: string): number {
  const rank = (one: string) => kind.children.find((child) => child.name === one)?.rank ?? 0;
  return present.findLastIndex((one) => rank(one) <= rank(name));
}

const escaped = (text: string): string =>
  text.replace(/[&<>"]/g, (letter) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[letter]!);

/** An element as XML. values: of attributes by "@name", its text by "", texts of children that must be there by name. */
export function written(kind: Kind, values: ReadonlyMap<string, string>): string {
  const attributes = kind.attributes
    .flatMap(({ name }) => (values.get(`@${name}`) ? [` ${name}="${escaped(values.get(`@${name}`)!)}"`] : []))
    .join("");
  const children = kind.children
    .filter((child) => child.required)
    .map(({ name }) => `<${name}>${escaped(values.get(name) ?? "")}</${name}>`)
    .join("");
  const inside = kind.text ? escaped(values.get("") ?? "") : children;
  return inside ? `<${kind.name}${attributes}>${inside}</${kind.name}>` : `<${kind.name}${attributes}/>`;
}
