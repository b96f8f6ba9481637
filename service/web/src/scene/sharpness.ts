/**
 * How many pixels a picture has. Where drawing is slow, what moves has fewer, and all of them once it rests.
 *
 * Without a graphics card edges are smoothed by drawing what rests larger than it is shown: to smooth each frame takes
 * most of the time there.
 */
import type { WebGLRenderer } from "three";

const SLOW = 30; // ms from wanting a frame to drawing it
const SLOW_FRAMES = 4; // one after the other
const COARSE = 0.5; // of the ratio of pixels
const COARSE_SOFTWARE = 0.7;
const FINE_SOFTWARE = 1.5;
const RESTED = 160; // ms without a frame
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

let known: boolean | undefined;

/** Whether the processor draws, for want of a graphics card. */
export function isSoftware(): boolean {
  if (known !== undefined) return known;
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  known = info ? SOFTWARE.test(String(gl!.getParameter(info.UNMASKED_RENDERER_WEBGL))) : false;
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return known;
}

export class Sharpness {
  private fine = 1;
  private ratio = 1;
  private slow = 0;
  private coarse = isSoftware();
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** redraw: draws the picture again, with all pixels. */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly redraw: () => void,
  ) {}

  /** Pixels of the screen for one of the page. */
  set screen(ratio: number) {
    this.ratio = ratio;
    this.fine = isSoftware() ? Math.max(ratio, FINE_SOFTWARE) : ratio;
    this.use(this.fine);
  }

  /** How many pixels are drawn now for one of the screen, along a side. */
  get larger(): number {
    return this.renderer.getPixelRatio() / this.ratio;
  }

  /** Before a frame of what moves. waited: ms since it was wanted. */
  move(waited: number): void {
    this.slow = waited > SLOW ? this.slow + 1 : 0;
    this.coarse ||= this.slow >= SLOW_FRAMES;
    if (!this.coarse) return;
    this.use(this.ratio * (isSoftware() ? COARSE_SOFTWARE : COARSE));
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.rest();
      this.redraw();
    }, RESTED);
  }

  /** Before a picture that is looked at. */
  rest(): void {
    this.use(this.fine);
  }

  close(): void {
    clearTimeout(this.timer);
  }

  private use(ratio: number): void {
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
  }
}
