import { describe, expect, it } from "vitest";
import { random } from "../../testing/random";
import { Steps } from "./steps";

describe("a value with its steps", () => {
  it("goes back through every step and forth again", () => {
    for (let seed = 0; seed < 50; seed++) {
      const draw = random(seed);
      const steps = new Steps(0);
      const all = [0];
      for (let step = draw.whole(0, 8); step > 0; step--) {
        all.push(all.length);
        steps.set(all.length - 1);
      }
      for (const value of [...all].reverse()) {
        expect(steps.now.value).toBe(value);
        steps.undo();
      }
      expect([steps.now.value, steps.canUndo.value]).toEqual([0, false]);
      for (const value of all) {
        expect(steps.now.value).toBe(value);
        steps.redo();
      }
      expect(steps.canRedo.value).toBe(false);
    }
  });

  it("takes steps of one kind in a row as one, and another begins anew after an undo", () => {
    const steps = new Steps("");
    for (const text of ["w", "wa", "walk"]) steps.set(text, "name");
    steps.undo();
    expect(steps.now.value).toBe("");
    steps.redo();
    steps.set("walks", "name");
    steps.undo();
    expect(steps.now.value).toBe("walk");
  });

  it("forgets what was undone once another step is made; what is learnt is none", () => {
    const steps = new Steps(1, [0]);
    steps.set(2);
    steps.undo();
    steps.amend(10);
    steps.set(3);
    expect(steps.canRedo.value).toBe(false);
    steps.undo();
    expect(steps.now.value).toBe(10);
    steps.undo();
    expect(steps.now.value).toBe(0);
  });
});
