/** The measurements of the file of a clip. */
import { get } from "../../../api/client";
import { nameAndAxis, UNITS, type Asked, type Measured } from "../../../motion/body/quantities";
import type { Clip } from "../../../state/clip/clip";
import { useAsync } from "../../../ui/useAsync";

export const useMeasurements = (clip: Clip) =>
  useAsync(
    (signal) =>
      get("/documents/{id}/measurements", { path: { id: clip.id }, query: { revision: clip.detail.revision }, signal }),
    [clip],
  );

/** The measurements of the file; unit of the one that is asked for, and the reason if it has no values. */
export function useMeasured(clip: Clip, asked: Asked): { measured: Measured[]; unit: string; reason: string } {
  const measured = useMeasurements(clip).value?.items ?? [];
  const chosen = measured.find((each) => each.function === asked.kind && each.name === nameAndAxis(asked)[0]);
  return { measured, unit: chosen?.unit ?? UNITS[asked.kind], reason: chosen?.reason ?? "" };
}
