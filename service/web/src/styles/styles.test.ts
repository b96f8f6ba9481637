/** A class belongs to one stylesheet: all of them are loaded together, so a second meaning would change the first. */
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "vitest";

const folder = import.meta.dirname;

/** The classes that have a rule of their own, outside of media queries. */
function classesOf(sheet: string): string[] {
  const plain = sheet.replace(/\/\*[\s\S]*?\*\//g, "").replace(/@[a-z]+[^{;]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}/g, "");
  const selectors = [...plain.matchAll(/([^{}]+)\{/g)].flatMap((match) => (match[1] ?? "").split(","));
  return selectors.map((one) => one.trim()).filter((one) => /^\.[\w-]+$/.test(one));
}

test("no class has rules in two stylesheets", () => {
  const sheets = readdirSync(folder).filter((name) => name.endsWith(".css"));
  expect(sheets.length).toBeGreaterThan(10);
  const owners = new Map<string, Set<string>>();
  for (const sheet of sheets)
    for (const name of classesOf(readFileSync(join(folder, sheet), "utf8")))
      owners.set(name, (owners.get(name) ?? new Set()).add(sheet));
  expect(owners.size).toBeGreaterThan(300);
  const shared = [...owners].filter(([, files]) => files.size > 1).map(([name, files]) => [name, ...files]);
  expect(shared).toEqual([]);
});
