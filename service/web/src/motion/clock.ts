/** A frame (from 0) as 0:02.167, or as timecode 00:00:02:05. */
export function clock(frame: number, perSecond: number, code = false): string {
  const seconds = frame / perSecond;
  const whole = Math.floor(seconds);
  const two = (value: number) => String(Math.floor(value)).padStart(2, "0");
  if (code) return `${two(whole / 3600)}:${two((whole / 60) % 60)}:${two(whole % 60)}:${two(frame - whole * perSecond + 1e-6)}`;
  return `${Math.floor(whole / 60)}:${(seconds % 60).toFixed(3).padStart(6, "0")}`;
}
