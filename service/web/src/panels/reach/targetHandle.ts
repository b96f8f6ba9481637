/** Arrows at the hand's target, which a pointer drags along X, Y and Z; the fields of the target follow. */
import { effect } from "@preact/signals";
import { numberAt } from "../../lists";
import { axisArrows, type Handle } from "../../scene/handle";
import type { Stage } from "../../scene/stage";
import type { Puller } from "../../ui/playing/MotionView";
import { number } from "../../words";
import type { Blending, Place } from "./blending";
import { b } from "./words";

export class TargetHandle implements Puller {
  private stage: Stage | null = null;
  /** Where the origin of the motion's world is in the picture, in the actor's unit: bodies are shown on one spot. */
  private base: readonly number[] = [0, 0, 0];
  private held: { name: string; handle: Handle; start: Place; place: Place } | null = null;

  constructor(private readonly blending: Blending) {}

  /** Draw on a stage; the first actor is the made motion. Returns how to end. */
  show(stage: Stage): () => void {
    this.stage = stage;
    const stop = effect(() => {
      const { blending } = this;
      blending.player.frame.value;
      blending.missed.value;
      blending.shown.value;
      blending.target.value;
      stage.handle = blending.aiming.value ? this.handle() : null;
      stage.ask();
    });
    return () => {
      stop();
      this.stage = null;
    };
  }

  stand(base: readonly number[]): void {
    this.base = base;
    if (this.stage?.handle) this.stage.handle = this.handle();
  }

  grab(x: number, y: number): boolean {
    const { stage, blending } = this;
    const name = stage?.arrowAt(x, y) ?? null;
    const place = blending.place.peek();
    if (!stage?.handle || name === null || !place) return false;
    blending.player.pause();
    this.held = { name, handle: stage.handle, start: stage.pullOf(stage.handle, name, x, y), place };
    stage.orbits = false;
    return true;
  }

  pull(x: number, y: number): void {
    if (!this.held || !this.stage) return;
    const { name, handle, start, place } = this.held;
    const by = this.stage.pullOf(handle, name, x, y);
    const metres = this.metres();
    this.blending.aim(
      place.map((one, axis) =>
        Number((one + (numberAt(by, axis) - numberAt(start, axis)) * metres).toFixed(3)),
      ) as Place,
    );
  }

  drop(): void {
    this.held = null;
    if (!this.stage) return;
    this.stage.orbits = true;
    this.stage.handle = this.blending.aiming.peek() ? this.handle() : null;
    this.stage.ask();
  }

  private metres(): number {
    return this.blending.shown.peek()?.preview.skeleton.metres ?? 1;
  }

  private handle(): Handle | null {
    const place = this.blending.place.peek();
    if (!place) return null;
    const at = place.map((one, axis) => one / this.metres() - numberAt(this.base, axis)) as Place;
    const missed = this.blending.missed.peek();
    const where = place.map((one) => number(one, 3)).join("  ");
    return {
      actor: 0,
      at,
      arrows: axisArrows(),
      held: this.held?.name ?? null,
      words: missed
        ? `${where} m   ${b("label.outOfReach", { size: number(missed.distance * 100, 1) })}`
        : `${where} m`,
    };
  }
}
