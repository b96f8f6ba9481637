// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { load, PAGES, rowOf } from "./pages";
import { pageOf } from "./state/session/route";
import { icons } from "./ui/icons";
import { en } from "./words/en";

describe.each(PAGES)("the page $name", (row) => {
  it("is found by its address", () => {
    expect(pageOf(row.about === "one" ? `${row.path}/1` : row.path, PAGES).page).toBe(row.name);
    expect(pageOf(`${row.path}/1`, PAGES).page).toBe(row.about === "nothing" ? "unknown" : row.name);
  });

  it("has words, an icon where the rail shows it, and a component", async () => {
    expect(en).toHaveProperty([row.title]);
    expect(Boolean(row.go)).toBe(Boolean(row.key));
    if (row.go) expect(en).toHaveProperty([row.go]);
    if (row.rail) expect(icons).toContain(row.icon);
    if (row.rail) expect(row.key).toBeDefined();
    if (row.within) expect(rowOf(row.within)?.rail).toBeDefined();
    expect(await load(row)).toBeTypeOf("function");
  });
});

it("has one row for each name, path and key", () => {
  for (const field of ["name", "path", "key"] as const) {
    const values = PAGES.flatMap((row) => row[field] ?? []);
    expect(new Set(values).size).toBe(values.length);
  }
});
