/** How loud the dance is, and whether it clicks. */
import { clicking, muted, volume } from "./sound";
import { d } from "./words";

export function SoundBar() {
  return (
    <>
      <button
        type="button"
        class="button quiet dense"
        aria-pressed={clicking.value}
        onClick={() => (clicking.value = !clicking.value)}
      >
        {d("label.clicks")}
      </button>
      <button
        type="button"
        class="button quiet dense"
        aria-pressed={muted.value}
        onClick={() => (muted.value = !muted.value)}
      >
        {d("label.mute")}
      </button>
      <input
        class="bench-volume"
        type="range"
        min={0}
        max={1}
        step={0.01}
        aria-label={d("label.volume")}
        value={volume.value}
        onInput={(event) => (volume.value = Number(event.currentTarget.value))}
      />
    </>
  );
}
