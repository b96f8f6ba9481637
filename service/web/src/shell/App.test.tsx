// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { beforeAll, describe, expect, it, vi } from "vitest";
import { load, PAGES } from "../pages";
import { commands } from "../state/session/keys";
import { followHistory, go, page } from "../state/session/route";
import { paletteOpen } from "../state/session/shell";
import { w } from "../words";
import { App } from "./App";

const root = document.createElement("div");
/** Run what a sequence of keys stands for. */
const press = (keys: string) =>
  commands()
    .find((one) => one.keys.includes(keys))
    ?.run();

beforeAll(async () => {
  // The frame is there though the server says nothing; formats are asked once, and other tests ask for them too.
  const refused = async () => new Response("{}", { status: 404 });
  vi.stubGlobal("fetch", (url: string) => (url.endsWith("/formats") ? refused() : new Promise(() => {})));
  document.body.append(root);
  followHistory(PAGES);
  await act(() => render(<App />, root));
  return async () => {
    // The code of pages that were opened still comes in, and must not outlive this file.
    await Promise.all(PAGES.map(load));
    render(null, root);
    vi.unstubAllGlobals();
  };
});

describe.each(PAGES.filter((row) => row.rail))("the page $name in the frame", (row) => {
  it("has a link with its icon in the rail", () => {
    const link = root.querySelector(`.rail a[href="${row.path}"]`);
    expect(link?.textContent).toBe(w(row.title));
    expect(link?.querySelector("svg")).not.toBeNull();
  });

  it("opens with its address, and the bar has its title", async () => {
    await act(() => go(row.path));
    expect(page.value).toBe(row.name);
    expect(root.querySelector(".bar .where")?.textContent).toBe(w(row.title));
    expect(root.querySelector(".rail [aria-current=page]")?.getAttribute("href")).toBe(row.path);
  });

  it("opens with its key, and from the palette", async () => {
    await act(() => go("/nowhere"));
    await act(() => press(`G then ${row.key}`));
    expect(page.value).toBe(row.name);
    await act(() => go("/nowhere"));
    await act(() => void (paletteOpen.value = `>${w(row.go!)}`));
    await act(() => root.querySelector<HTMLElement>(".palette [role=option]")?.click());
    expect(page.value).toBe(row.name);
  });
});
