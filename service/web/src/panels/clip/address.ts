/** The view of a clip in the address: frame, loop, selection, camera, tab. Frames in addresses count from 1. */
import { effect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Clip } from "../../state/clip/clip";
import { noteParams, param } from "../../state/session/route";
import { timeJump } from "../../state/session/shell";

export function useAddress(clip: Clip): void {
  useEffect(() => {
    const { player } = clip;
    const [first, last] = [Number(param("in")), Number(param("out"))];
    if (first >= 1 && last >= first) player.loop.value = [first - 1, Math.min(clip.frames, last) - 1];
    const frame = Number(param("f"));
    if (frame >= 1) player.seek(frame - 1);
    const speed = Number(param("speed"));
    if (speed) player.speed.value = speed;
    const bones = param("sel")
      .split(",")
      .filter((name) => clip.skeleton.byName.has(name));
    if (bones.length) clip.select(bones);
    timeJump.value = (text) => {
      const seconds = /^([\d.]+)\s*s$/.exec(text);
      player.pause();
      player.seek(seconds ? Number(seconds[1]) * player.perSecond : Number(text) - 1);
    };
    const stop = effect(() => {
      const loop = player.loop.value;
      noteParams({
        f: player.frame.value ? String(player.frame.value + 1) : null,
        in: loop ? String(loop[0] + 1) : null,
        out: loop ? String(loop[1] + 1) : null,
        sel: clip.selection.value.bones.join(",") || null,
        speed: player.speed.value === 1 ? null : String(player.speed.value),
      });
    });
    return () => {
      stop();
      timeJump.value = null;
    };
  }, [clip]);
}
