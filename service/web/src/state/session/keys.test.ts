// @vitest-environment happy-dom
import { describe, expect, it, vi } from "vitest";
import { chord, commands, followKeys, offer } from "./keys";

const pressed = (code: string, more: KeyboardEventInit = {}) =>
  new KeyboardEvent("keydown", { code, bubbles: true, cancelable: true, composed: true, ...more });

describe("a chord", () => {
  it("is what stands on the key of a usual keyboard, under any layout and language", () => {
    expect(chord(pressed("KeyK", { key: "ㅏ" }))).toBe("K");
    expect(chord(pressed("KeyK", { key: "K", shiftKey: true }))).toBe("Shift+K");
    expect(chord(pressed("KeyZ", { key: "z", ctrlKey: true, shiftKey: true }))).toBe("Ctrl+Shift+Z");
    expect(chord(pressed("KeyS", { key: "s", metaKey: true }))).toBe("Ctrl+S");
    expect(chord(pressed("Digit5", { key: "5" }))).toBe("5");
    expect(chord(pressed("ArrowLeft", { shiftKey: true }))).toBe("Shift+Left");
    expect(chord(pressed("Space", { key: " ", altKey: true }))).toBe("Alt+Space");
    expect(chord(pressed("Slash", { key: "/" }))).toBe("/");
    expect(chord(pressed("Slash", { key: "?", shiftKey: true }))).toBe("?");
    expect(chord(pressed("Minus", { key: "?", shiftKey: true }))).toBe("?");
  });
});

describe("commands", () => {
  followKeys();
  const press = (code: string, more: KeyboardEventInit = {}, at: EventTarget = document.body) => {
    const event = pressed(code, more);
    at.dispatchEvent(event);
    return event;
  };

  it("run by their keys, where they can run, and only while they are offered", () => {
    const run = vi.fn();
    let can = true;
    const stop = offer("test", [
      { id: "a", word: "button.close", keys: ["Shift+Left", "G then L"], run, when: () => can },
    ]);
    expect(press("ArrowLeft", { shiftKey: true }).defaultPrevented).toBe(true);
    expect(run).toHaveBeenCalledTimes(1);
    press("KeyG");
    press("KeyL");
    expect(run).toHaveBeenCalledTimes(2);
    press("KeyL");
    expect(run).toHaveBeenCalledTimes(2);
    can = false;
    expect(press("ArrowLeft", { shiftKey: true }).defaultPrevented).toBe(false);
    expect(run).toHaveBeenCalledTimes(2);
    stop();
    can = true;
    press("ArrowLeft", { shiftKey: true });
    expect(run).toHaveBeenCalledTimes(2);
    expect(commands()).toEqual([]);
  });

  it("leave letters to whoever types them", () => {
    const run = vi.fn();
    const stop = offer("test", [
      { id: "a", word: "button.close", keys: ["K"], run },
      { id: "b", word: "button.save", keys: ["Ctrl+S"], run },
    ]);
    const field = document.body.appendChild(document.createElement("input"));
    press("KeyK", {}, field);
    expect(run).not.toHaveBeenCalled();
    press("KeyS", { ctrlKey: true }, field);
    expect(run).toHaveBeenCalledTimes(1);
    press("KeyK");
    expect(run).toHaveBeenCalledTimes(2);
    field.remove();
    stop();
  });

  it("of the page go before those of the shell; an owner that offers anew is not taken back by the old", () => {
    const [shell, page] = [vi.fn(), vi.fn()];
    const stopShell = offer("shell", [{ id: "a", word: "button.close", keys: ["K"], run: shell }]);
    const stopOld = offer("page", [{ id: "b", word: "button.close", keys: ["K"], run: vi.fn() }]);
    const stopNew = offer("page", [{ id: "b", word: "button.close", keys: ["K"], run: page }]);
    stopOld();
    press("KeyK");
    expect([shell.mock.calls.length, page.mock.calls.length]).toEqual([0, 1]);
    stopNew();
    press("KeyK");
    expect(shell).toHaveBeenCalledTimes(1);
    stopShell();
  });
});
