import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { agreedColours } from "../../motion/timeline/colours";
import { agreed, anatomical, followProject, inUse, loadVocabulary, namesLike } from "./vocabulary";

let answers: Record<string, () => Promise<unknown>> = {};
let asked: string[] = [];

beforeEach(() => {
  asked = [];
  vi.stubGlobal("fetch", async (address: string) => {
    const { pathname, search } = new URL(address, "http://x");
    asked.push(pathname + search);
    const body = await answers[pathname]!();
    return new Response(JSON.stringify(body), { headers: { "content-type": "application/json" } });
  });
});
afterEach(() => vi.unstubAllGlobals());

const words = (...names: string[]) => ({ items: names.map((name, at) => ({ name, colour: at ? null : 3 })) });

describe("motion names", () => {
  it("are asked once, again where they are wanted anew or the server did not answer", async () => {
    answers = { "/api/v1/motion-names": () => Promise.reject(new TypeError("offline")) };
    await loadVocabulary();
    expect(inUse.value).toEqual([]);
    answers["/api/v1/motion-names"] = () =>
      Promise.resolve({
        items: [{ name: "left-leg-kick" }, { name: "walk" }],
        vocabulary: [
          { part: "knee", sided: true, movements: ["flexion"] },
          { part: "trunk", sided: false, movements: ["bend", "turn"] },
        ],
      });
    await loadVocabulary();
    await loadVocabulary();
    expect(asked.length).toBe(2);
    await loadVocabulary(true);
    expect(asked.length).toBe(3);
    expect(inUse.value.map((one) => one.name)).toEqual(["left-leg-kick", "walk"]);
    expect(anatomical.value).toEqual(["left-knee-flexion", "right-knee-flexion", "trunk-bend", "trunk-turn"]);
  });

  it("are those of the project that is open, not of one whose answer comes late", async () => {
    let late: (answer: unknown) => void = () => undefined;
    answers = { "/api/v1/vocabulary": () => new Promise((resolve) => (late = resolve)) };
    const first = followProject("Gait");
    await vi.waitFor(() => expect(asked).toEqual(["/api/v1/vocabulary?project=Gait"]));
    answers["/api/v1/vocabulary"] = () => Promise.resolve(words("kick high", "stand"));
    await followProject("Dance");
    late(words("of Gait"));
    await first;
    expect(agreed.value.map((one) => one.name)).toEqual(["kick high", "stand"]);
    expect([...agreedColours.value]).toEqual([["kick high", 3]]);
  });

  it("are found by all words of a text: agreed ones first, then those in use, each once", () => {
    inUse.value = [{ name: "left-leg-kick" }, { name: "kick high" }] as typeof inUse.value;
    expect(namesLike("KICK")).toEqual(["kick high", "left-leg-kick"]);
    expect(namesLike("leg left")).toEqual(["left-leg-kick"]);
    expect(namesLike("knee-left")).toEqual(["left-knee-flexion"]);
    expect(namesLike("", 3)).toHaveLength(3);
  });

  it("are none of a project that is closed or cannot be read", async () => {
    answers = { "/api/v1/vocabulary": () => Promise.reject(new TypeError("offline")) };
    await followProject("Secret");
    expect(agreed.value).toEqual([]);
    await followProject(null);
    expect([agreed.value, agreedColours.value.size]).toEqual([[], 0]);
  });
});
