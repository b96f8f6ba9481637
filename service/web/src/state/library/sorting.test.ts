import { describe, expect, it } from "vitest";
import { asOrder, asSort, COLUMNS, NEWEST, pressed, type Column } from "./sorting";

describe("the order of the library", () => {
  it("is in the address as the server takes it", () => {
    for (const column of Object.keys(COLUMNS) as Column[]) {
      for (const down of [false, true]) expect(asOrder(asSort({ column, down }))).toEqual({ column, down });
    }
    expect(asSort(NEWEST)).toBe("newest");
    expect(asSort({ column: "created", down: false })).toBe("created");
  });

  it("is the newest first where the address says nothing that is known", () => {
    for (const text of ["", "newest", "colour", "-", "toString", "-constructor"]) expect(asOrder(text)).toEqual(NEWEST);
  });

  it("turns where its column is pressed again", () => {
    expect(pressed(NEWEST, "name")).toEqual({ column: "name", down: false });
    expect(pressed({ column: "name", down: false }, "name")).toEqual({ column: "name", down: true });
    expect(pressed(NEWEST, "duration")).toEqual({ column: "duration", down: true });
    expect(pressed({ column: "duration", down: true }, "duration")).toEqual({ column: "duration", down: false });
  });
});
