// @vitest-environment happy-dom
import { render } from "preact";
import { act } from "preact/test-utils";
import { describe, expect, it } from "vitest";
import { ApiError, Offline } from "../api/client";
import { useAsync, type Loaded } from "./useAsync";

/** A component that asks, and what it shows; each question is answered by hand. */
function asking() {
  const open = new Map<string, { answer: (value: string) => void; refuse: (error: unknown) => void }[]>();
  const shown: Loaded<string>[] = [];
  const ask = (key: string) =>
    new Promise<string>((answer, refuse) => open.set(key, [...(open.get(key) ?? []), { answer, refuse }]));
  const One = ({ question, fresh = 0 }: { question: string; fresh?: number }) => {
    shown.push(useAsync(() => ask(question), [question], [fresh]));
    return null;
  };
  const host = document.createElement("div");
  const show = (question: string, fresh = 0) => act(() => render(<One question={question} fresh={fresh} />, host));
  const settle = async (
    key: string,
    how: (last: { answer: (value: string) => void; refuse: (error: unknown) => void }) => void,
    which = -1,
  ) => {
    how(open.get(key)!.at(which)!);
    await act(async () => {
      await Promise.resolve();
    });
  };
  return { show, settle, shown, now: () => shown.at(-1)! };
}

const refused = new ApiError(422, { title: "no" });

describe("what is shown of a question", () => {
  it("is never the answer to another, not for one rendering", async () => {
    const one = asking();
    await one.show("a");
    await one.settle("a", (it) => it.answer("of a"));
    expect(one.now().value).toBe("of a");
    const renderings = one.shown.length;
    await one.show("b");
    expect(one.shown.slice(renderings).map((each) => each.value)).not.toContain("of a");
    expect(one.now()).toMatchObject({ value: undefined, before: "of a", busy: true });
  });

  it("is nothing once it failed, and the error only while it is the question", async () => {
    const one = asking();
    await one.show("a");
    await one.settle("a", (it) => it.answer("of a"));
    await one.show("b");
    await one.settle("b", (it) => it.refuse(refused));
    expect(one.now()).toMatchObject({ value: undefined, before: undefined, error: refused, busy: false });
    await one.show("c");
    expect(one.now()).toMatchObject({ value: undefined, before: undefined, error: undefined, busy: true });
  });

  it("is its own answer where one that was asked before comes late", async () => {
    const one = asking();
    await one.show("a");
    await one.show("b");
    await one.settle("b", (it) => it.answer("of b"));
    await one.settle("a", (it) => it.answer("of a"));
    expect(one.now().value).toBe("of b");
    await one.show("a");
    await one.settle("a", (it) => it.refuse(refused));
    expect(one.now().error).toBe(refused);
  });

  it("stays while the same question is asked again, and while no answer comes", async () => {
    const one = asking();
    await one.show("a");
    await one.settle("a", (it) => it.answer("first"));
    await one.show("a", 1);
    expect(one.now()).toMatchObject({ value: "first", busy: true });
    await one.settle("a", (it) => it.refuse(new Offline("away")));
    expect(one.now()).toMatchObject({ value: "first", busy: false });
    await act(() => one.now().again());
    await one.settle("a", (it) => it.refuse(refused));
    expect(one.now()).toMatchObject({ value: undefined, error: refused });
  });
});
