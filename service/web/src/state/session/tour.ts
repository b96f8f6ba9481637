/** The guided tour: a few steps on pages of the studio, begun from the help and left at any time. */
import { effect, signal } from "@preact/signals";
import type { Word } from "../../words";
import { go } from "./route";

export interface TourStep {
  path: string;
  text: Word;
}

export const TOUR: readonly TourStep[] = [
  { path: "/library", text: "help.tourLibrary" },
  { path: "/library?folders=project", text: "help.tourFolders" },
  { path: "/xpath", text: "help.tourAsk" },
  { path: "/compose", text: "help.tourCompose" },
  { path: "/measure", text: "help.tourMeasure" },
  { path: "/dance", text: "help.tourMake" },
  { path: "/library", text: "help.tourEnd" },
];

/** The step that is shown, from 0; null while there is no tour. */
export const tourStep = signal<number | null>(null);

/** Each step opens its page; what is done there does not end the tour. */
effect(() => {
  const step = tourStep.value === null ? undefined : TOUR[tourStep.value];
  if (step) go(step.path);
});
