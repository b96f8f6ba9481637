// @vitest-environment happy-dom
import { effect } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { PAGES } from "../../pages";
import { followHistory, go, noteParams, page, pageOf as pageAmong, param, route, setParams } from "./route";

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

describe("the address", () => {
  beforeEach(() => {
    vi.useFakeTimers();
    history.replaceState(null, "", "/library");
    followHistory(PAGES);
  });
  afterEach(() => vi.useRealTimers());

  it("follows a link, and the way back", () => {
    go("/clips/1?f=3");
    expect([route.value.page, route.value.id, param("f"), location.pathname]).toEqual(["clip", "1", "3", "/clips/1"]);
    history.replaceState(null, "", "/xpath?q=a");
    dispatchEvent(new PopStateEvent("popstate"));
    expect([page.value, param("q"), param("f")]).toEqual(["xpath", "a", ""]);
  });

  it("has parameters in memory at once, in the bar soon, and not twice a second more than it may", () => {
    setParams({ q: "walk", project: "Gait" });
    expect([param("q"), location.search]).toEqual(["walk", ""]);
    setParams({ q: null });
    vi.advanceTimersByTime(250);
    expect(location.search).toBe("?project=Gait");
    setParams({ project: "" });
    vi.advanceTimersByTime(250);
    expect(location.search).toBe("");
  });

  it("is written before another page opens, so that the way back leads to what was seen", () => {
    const before = history.length;
    setParams({ f: "7" });
    const written = vi.spyOn(history, "replaceState");
    go("/xpath");
    expect(written.mock.calls.map(([, , address]) => address)).toEqual(["/library?f=7"]);
    expect(history.length).toBe(before + 1);
    setParams({ q: "x" }, true);
    expect(location.search).toBe("?q=x");
    expect(history.length).toBe(before + 2);
    written.mockRestore();
  });

  it("changes with time without anything being drawn", () => {
    let drawn = -1;
    const stop = effect(() => {
      void route.value;
      drawn++;
    });
    noteParams({ f: "9" });
    vi.advanceTimersByTime(250);
    expect([location.search, drawn]).toEqual(["?f=9", 0]);
    stop();
  });

  const click = (html: string, more: MouseEventInit = {}): boolean => {
    document.body.innerHTML = html;
    const event = new MouseEvent("click", { bubbles: true, cancelable: true, ...more });
    // What the router leaves to the browser is stopped here: nothing is loaded in tests.
    addEventListener("click", (one) => one.preventDefault(), { once: true });
    let taken = false;
    document.addEventListener("click", (one) => (taken = one.defaultPrevented), { once: true });
    document.querySelector("a")?.dispatchEvent(event);
    return taken;
  };

  it("is changed by links of the studio alone", () => {
    expect(click('<a href="/xpath?q=b">x</a>')).toBe(true);
    expect([page.value, param("q")]).toEqual(["xpath", "b"]);
    for (const html of [
      '<a href="/api/v1/documents">x</a>',
      '<a href="/docs">x</a>',
      '<a href="/faces" target="_blank">x</a>',
      '<a href="/faces" download>x</a>',
      '<a href="https://example.org/faces">x</a>',
    ])
      expect(click(html), html).toBe(false);
    expect(click('<a href="/faces">x</a>', { ctrlKey: true })).toBe(false);
    expect(page.value).toBe("xpath");
  });

  it("stays that of the view where a link leads within the page, which gets the focus", () => {
    go("/library?q=1");
    expect(click('<a href="#page">x</a><main id="page" tabindex="-1"></main>')).toBe(true);
    expect(document.activeElement?.id).toBe("page");
    expect(location.hash).toBe("");
  });
});
