// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import type { Schemas } from "../../api/client";
import { folderAddress, foldersOf, groupingsOf, openFolder, readGrouping } from "./folders";

const found = {
  projects: [{ value: "gait", documents: 3 }],
  motion_names: [],
  formats: [{ value: "bvh", documents: 3 }],
  skeletons: [{ skeleton: 7, joints: 20, documents: 3 }],
  rates: [{ value: 120, documents: 2 }],
  properties: [
    { name: "subject", documents: 2, numbers: null, texts: [{ value: "Ana: left", documents: 2 }] },
    { name: "age", documents: 2, numbers: { edges: [1, 2], counts: [2] }, texts: [] },
  ],
} as unknown as Schemas["FacetList"];

describe("folders of the library", () => {
  it("are the facets that have values, and properties that are texts", () => {
    expect(groupingsOf(found)).toEqual(["project", "format", "skeleton", "rate", "property:subject"]);
    for (const one of groupingsOf(found)) expect(readGrouping(one)).toBe(one);
    for (const text of ["", "property:", "created"]) expect(readGrouping(text)).toBeNull();
  });

  it("have the counts of the service", () => {
    expect(foldersOf(found, "skeleton")).toEqual([{ value: "7", joints: 20, documents: 3 }]);
    expect(foldersOf(found, "property:subject")).toEqual([{ value: "Ana: left", documents: 2 }]);
    expect(foldersOf(found, "property:gone")).toEqual([]);
  });

  it.each(["project", "rate", "property:subject"] as const)("open and close by the address: %s", (grouping) => {
    const before = { format: "bvh", property: ["age:2..3"] };
    const params = new URLSearchParams(`folders=${grouping}&sort=name&format=bvh&property=age:2..3`);
    const opened = new URL(folderAddress(before, params, grouping, "Ana: left"), "http://here").searchParams;
    expect([opened.get("sort"), opened.get("folders"), opened.get("format")]).toEqual(["name", grouping, "bvh"]);
    expect(opened.getAll("property")).toContain("age:2..3");
    const property = opened.getAll("property");
    const filter = { ...Object.fromEntries(opened), property };
    expect(openFolder(before, grouping)).toBeNull();
    expect(openFolder(filter, grouping)).toBe("Ana: left");
    const closed = new URL(
      folderAddress({ format: "bvh", property, project: "x", rate: "y" }, opened, grouping, null),
      "http://h",
    );
    expect(openFolder({ property: closed.searchParams.getAll("property") }, grouping)).toBeNull();
    expect(closed.searchParams.has(grouping)).toBe(false);
  });
});
