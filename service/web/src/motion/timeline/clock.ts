/**
 * A frame (from 0) as 0:02.167, or as timecode 00:00:02:05. Timecode counts whole frames a second, as many as come next to
 * the rate: 29.97 as 30, and 120.0005 (which files mean by 0.0083333 s) as 120.
 */
export function clock(frame: number, perSecond: number, code = false): string {
  const two = (value: number) => String(Math.floor(value)).padStart(2, "0");
  if (code) {
    const rate = Math.max(1, Math.round(perSecond));
    const seconds = Math.floor(frame / rate);
    return `${two(seconds / 3600)}:${two((seconds / 60) % 60)}:${two(seconds % 60)}:${two(frame - seconds * rate)}`;
  }
  const thousandths = Math.round((frame / perSecond) * 1000);
  return `${Math.floor(thousandths / 60_000)}:${((thousandths % 60_000) / 1000).toFixed(3).padStart(6, "0")}`;
}
