// @vitest-environment happy-dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ApiError } from "../../api/client";
import { copyText, dismiss, held, note, notes, refuse } from "./notes";

beforeEach(() => {
  vi.useFakeTimers();
  notes.value = [];
  held.clear();
});
afterEach(() => vi.useRealTimers());
const texts = () => notes.value.map((one) => one.text);

describe("notes", () => {
  it("show the last three, longer where there is a way back, longest where something failed", () => {
    note("done");
    note("undo?", { action: { text: "undo", run: () => undefined } });
    note("failed", { bad: true });
    expect(texts()).toEqual(["done", "undo?", "failed"]);
    vi.advanceTimersByTime(6000);
    expect(texts()).toEqual(["undo?", "failed"]);
    vi.advanceTimersByTime(4000);
    expect(texts()).toEqual(["failed"]);
    vi.advanceTimersByTime(10_000);
    expect(texts()).toEqual([]);
    for (const one of "abcd") note(one);
    expect(texts()).toEqual(["b", "c", "d"]);
  });

  it("stay while they are held", () => {
    note("read me");
    const { id } = notes.value[0]!;
    held.add(id);
    dismiss(id);
    vi.advanceTimersByTime(60_000);
    expect(texts()).toEqual(["read me"]);
    held.delete(id);
    vi.advanceTimersByTime(1000);
    expect(texts()).toEqual([]);
  });

  it("tell what the server said with its remedy, and nothing of aborted requests", () => {
    refuse(new DOMException("stopped", "AbortError"));
    expect(texts()).toEqual([]);
    refuse(new ApiError(422, { title: "Invalid", detail: "No frames.", remedy: "Add some." }));
    expect(notes.value[0]).toMatchObject({ text: "No frames.", detail: "Add some.", bad: true });
    refuse(new ApiError(412, { title: "Precondition failed" }));
    expect(notes.value[1]?.text).not.toContain("Precondition");
    expect(notes.value[1]?.action).toBeDefined();
    const logged = vi.spyOn(console, "error").mockImplementation(() => undefined);
    refuse(new Error("broken"));
    expect([notes.value[2]?.text, logged.mock.calls.length]).toEqual(["broken", 1]);
  });

  it("say that a text was copied when it was", async () => {
    const written = vi.spyOn(navigator.clipboard, "writeText").mockResolvedValue();
    await copyText("a line", "copied");
    expect([written.mock.calls[0]?.[0], texts()]).toEqual(["a line", ["copied"]]);
  });
});
