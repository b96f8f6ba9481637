import { describe, expect, it } from "vitest";
import { composerOf, documentsOf, labelTable, parseExample, within, writeExample, type Hit } from "./asked";

const hit = (document: string, first: number, last: number, distance = 0): Hit => ({
  document,
  first,
  last,
  distance,
  name: document,
  revision: 1,
});

describe("the example in the address", () => {
  it("is a pose or a motion, and is written as it was read", () => {
    for (const text of ["30", "10-40", "7-7"]) expect(writeExample(parseExample(text)!)).toBe(text);
    expect(parseExample("30")).toEqual({ first: 30 });
    expect(parseExample("10-40")).toEqual({ first: 10, last: 40 });
  });
  it("is nothing else", () => {
    for (const text of ["", "0", "-3", "40-10", "1-2-3", "a", "1.5", "0-4", "9999999999"])
      expect(parseExample(text)).toBeNull();
  });
});

describe("the hits", () => {
  const hits = [hit("a", 1, 9, 0), hit("b", 4, 12, 0.1), hit("a", 30, 38, 0.4)];
  it("are cut at a distance", () => {
    expect(within(hits, 0.1)).toEqual(hits.slice(0, 2));
    expect(within(hits, 0)).toEqual(hits.slice(0, 1));
  });
  it("are a table of labels of exactly their frames, with any name", () => {
    expect(labelTable(hits.slice(0, 2), 'turn, "left"')).toBe(
      'document,label,first,last\na,"turn, ""left""",1,9\nb,"turn, ""left""",4,12\n',
    );
  });
  it("are pieces of the composer, and clips named once", () => {
    expect(composerOf(hits.slice(1))).toBe("/compose?s=b:4-12,a:30-38");
    expect(documentsOf(hits)).toEqual(["a", "b"]);
  });
});
