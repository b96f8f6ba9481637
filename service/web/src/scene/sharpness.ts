/** Fewer pixels while something moves where drawing is slow, as without a graphics card; all of them once it rests. */
import type { WebGLRenderer } from "three";

const SLOW = 30; // ms from wanting a frame to drawing it
const SLOW_FRAMES = 4; // one after the other
const COARSE = 0.5; // of the ratio of pixels
const RESTED = 160; // ms without a frame

export class Sharpness {
  private ratio = 1;
  private slow = 0;
  private coarse = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** redraw: draws the picture again, with all pixels. */
  constructor(private readonly renderer: WebGLRenderer, private readonly redraw: () => void) {}

  /** The ratio of pixels of a picture that rests. */
  set full(ratio: number) {
    this.ratio = ratio;
    this.use(ratio);
  }

  /** Before a frame of what moves. waited: ms since it was wanted. */
  move(waited: number): void {
    this.slow = waited > SLOW ? this.slow + 1 : 0;
    this.coarse ||= this.slow >= SLOW_FRAMES;
    if (!this.coarse) return;
    this.use(this.ratio * COARSE);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.rest();
      this.redraw();
    }, RESTED);
  }

  /** Before a picture that is looked at. */
  rest(): void {
    this.use(this.ratio);
  }

  close(): void {
    clearTimeout(this.timer);
  }

  private use(ratio: number): void {
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
  }
}
