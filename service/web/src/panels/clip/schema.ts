/** What may stand where, read from mcml.dtd, for completion in the text. */
import type { ElementSpec } from "@codemirror/lang-xml";

/** Elements with their children and attributes. Enumerated attributes have their values. */
export function schema(dtd: string): ElementSpec[] {
  const text = dtd.replace(/<!--[\s\S]*?-->/g, "");
  const attributes = new Map<string, { name: string; values?: string[] }[]>();
  for (const [, element, body] of text.matchAll(/<!ATTLIST\s+(\S+)([\s\S]*?)>/g)) {
    const found = attributes.get(element) ?? [];
    for (const [, name, type] of body.matchAll(/(\S+)\s+(CDATA|NMTOKENS?|IDREFS?|ID|\([^)]*\))\s+(?:#REQUIRED|#IMPLIED|#FIXED\s+"[^"]*"|"[^"]*")/g)) {
      found.push(type.startsWith("(") ? { name, values: type.slice(1, -1).split("|").map((one) => one.trim()) } : { name });
    }
    attributes.set(element, found);
  }
  return [...text.matchAll(/<!ELEMENT\s+(\S+)\s+([\s\S]*?)>/g)].map(([, name, model]) => ({
    name,
    top: name === "mcml",
    children: [...new Set([...model.matchAll(/[A-Za-z_][\w.-]*/g)].map(([one]) => one).filter((one) => !/^(EMPTY|ANY|PCDATA)$/.test(one)))],
    attributes: attributes.get(name) ?? [],
  }));
}
