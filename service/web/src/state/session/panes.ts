/** Sizes and folds of panels, kept for each browser. */
import { kept } from "./settings";

export const leftFolded = kept("leftFolded", false);
export const rightFolded = kept("rightFolded", false);
export const facetsWide = kept("facets", 240);
export const previewWide = kept("preview", 320);
export const dockWide = kept("dock", 420);
export const timelineTall = kept("timeline", 190);
/** The library's preview: beside the cards where there is room, else when it is asked for. */
export const previewOpen = kept("previewOpen", innerWidth >= 1400);
