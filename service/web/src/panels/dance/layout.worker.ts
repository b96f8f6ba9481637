/** Lays out a graph beside the page, so that nothing waits for it. */
import { layOut, type Link } from "../../motion/dance/layout";

export interface LayoutWish {
  turn: number;
  count: number;
  links: Link[];
  before?: Float32Array;
}
export interface LaidOut {
  turn: number;
  places: Float32Array;
}

self.onmessage = ({ data }: MessageEvent<LayoutWish>) => {
  const places = layOut(data.count, data.links, data.before);
  self.postMessage({ turn: data.turn, places } satisfies LaidOut, { transfer: [places.buffer] });
};
