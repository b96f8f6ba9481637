// @vitest-environment happy-dom
import { afterEach, expect, it, vi } from "vitest";
import { characters, loadCharacters, nameOfCharacter } from "./characters";

afterEach(() => vi.unstubAllGlobals());

it("lists the characters of the library, and keeps the list where there is no answer", async () => {
  const avatar = { document: "a", name: "avatar", project: "default", vertices: 9 };
  vi.stubGlobal("fetch", async () => Response.json({ items: [avatar], unread: 0 }));
  await loadCharacters();
  expect(nameOfCharacter("a")).toBe("avatar");
  expect(nameOfCharacter("b")).toBeNull();
  vi.stubGlobal("fetch", async () => Response.json({ title: "Not for visitors" }, { status: 403 }));
  await loadCharacters();
  expect(characters.value).toEqual([avatar]);
});
