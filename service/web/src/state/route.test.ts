// @vitest-environment happy-dom
import { describe, expect, it } from "vitest";
import { PAGES } from "../pages";
import { pageOf as pageAmong } from "./route";

const pageOf = (path: string) => pageAmong(path, PAGES);

describe("the page of an address", () => {
  it("is told by its parts", () => {
    expect(pageOf("/")).toEqual({ page: "library", id: "" });
    expect(pageOf("/xpath")).toEqual({ page: "xpath", id: "" });
    expect(pageOf("/clips/a%20b")).toEqual({ page: "clip", id: "a b" });
    expect(pageOf("/settings/activity")).toEqual({ page: "settings", id: "activity" });
    expect(pageOf("/library/")).toEqual({ page: "library", id: "" });
  });

  it.each([
    "/nowhere",
    "/clips",
    "/clips/a/b",
    "/library/x",
    "/constructor",
    "/__proto__",
    "/clips/%E0%A4%A",
    "/index.php",
  ])("is unknown of %s", (path) => {
    expect(pageOf(path).page).toBe("unknown");
  });
});
