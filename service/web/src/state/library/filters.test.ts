import { describe, expect, it } from "vitest";
import { addressOf, asConditions, asFilter, sameFilter } from "./filters";

const FILTER = { project: "film", skeleton: "3", property: ["age:20..30", "take:calm"], length: "2..10" };

describe("filters that are kept", () => {
  it("come back as they were", () => {
    const where = asConditions(FILTER)!;
    expect(where).toMatchObject({ skeleton: 3, length: "2..10" });
    expect(asFilter(where)).toEqual(FILTER);
    expect(asFilter({ ...where, q: null, format: undefined, property: [] })).toEqual({
      project: "film",
      skeleton: "3",
      length: "2..10",
    });
  });

  it("are no conditions where they ask a question or name a collection", () => {
    expect(asConditions({ xpath: "//frame" })).toBe(null);
    expect(asConditions({ collection: "a", project: "b" })).toBe(null);
    expect(asConditions({})).toBe(null);
  });

  it("are the same whatever their order", () => {
    expect(sameFilter(FILTER, { ...FILTER, property: [...FILTER.property].reverse() })).toBe(true);
    expect(sameFilter(FILTER, { ...FILTER, length: "2.." })).toBe(false);
    expect(sameFilter({}, FILTER)).toBe(false);
  });

  it("are an address, in which the view stays and other filters go", () => {
    const found = addressOf({ property: ["a:1", "b:2"] }, new URLSearchParams("view=list&q=x&project=y"), [
      "q",
      "project",
      "property",
    ]);
    expect(found).toBe("/library?view=list&property=a%3A1&property=b%3A2");
    expect(addressOf({}, new URLSearchParams("q=x"), ["q"])).toBe("/library");
  });
});
