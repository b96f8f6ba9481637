/** What is drawn of the open clip in a frame: its body, ghosts of it in time, lines that its joints go along. */
import { numberAt } from "../../../lists";
import type { Skeleton } from "../../../motion/body/skeleton";
import type { Skin } from "../../../motion/body/skin";
import { characterOf, wornAt, type Character } from "../../../motion/loading/character";
import type { Pose, Shown } from "../../../scene/stage";
import { chosenCharacter } from "../../../state/clip/characters";
import type { Clip } from "../../../state/clip/clip";
import type { Compared as Earlier } from "../../../state/clip/compared";
import { touched } from "../../../state/editing/draft";
import { shown } from "../actions";
import { posing } from "../posing/posing";

const GHOST_SECONDS = [-0.2, -0.1, 0.1, 0.2];
const TRAIL_SECONDS = 1;

/** The body of the open clip, where bodies are wanted and it can have one; what moves it is fetched then. A character
 * of the library shows the stored motion: while a draft changes it, there is none. */
export function wearBody(clip: Clip): Character | null {
  const { detail, skeleton, player } = clip;
  const found = shown.value.body
    ? characterOf({ id: clip.id, revision: detail.revision, skeleton }, chosenCharacter.value).value
    : null;
  const worn = found?.skin && !posing.value && !(found.frames && isRedrawn(clip)) ? found : null;
  clip.turning.value = Boolean(worn && !worn.frames);
  if (worn?.frames) {
    const direction = player.playing.value ? Math.sign(player.speed.value) : 0;
    for (const blocks of [worn.frames.positions, worn.frames.rotations]) {
      blocks.arrived.value;
      blocks.want(player.frame.value, direction, player.perSecond * Math.abs(player.speed.peek()), player.range[0]);
    }
  } else if (worn) clip.rotations.arrived.value;
  return worn;
}

export const skinOfBody = (body: Character | null): Skin | null => body?.skin ?? null;

/** Whether a draft changes the motion or the bones. */
export const isRedrawn = (clip: Clip): boolean =>
  touched(clip.draft.value) !== null || clip.shape.value !== clip.skeleton;

export function poseAt(clip: Clip, frame: number, show: Shown, selected: number[], body: Character | null): Pose {
  const ghosts = show.ghosts ? ghostFrames(clip, frame) : [];
  const turned = clip.turning.peek();
  return {
    positions: posing.value?.positions(frame) ?? clip.positions(frame),
    turns: turned ? clip.turns(frame) : null,
    before: ghosts.map((at) => (at === null ? null : clip.positions(at, false))),
    turnsBefore: turned ? ghosts.map((at) => (at === null ? null : clip.turns(at, false))) : [],
    worn: body?.frames ? wornAt(body, frame) : null,
    wornBefore: body?.frames ? ghosts.map((at) => (at === null ? null : wornAt(body, at))) : [],
    trail: show.trails ? trailsOf(clip, frame, selected) : [],
  };
}

/** The same frame as another revision has it, from the open one's origin; null where it has none. */
export function positionsThen(other: Earlier, frame: number, { view }: Skeleton): Float32Array | null {
  const place = other.at(frame);
  const found = place === null ? null : other.blocks.frame(place);
  return found && found.map((one, at) => one + numberAt(other.origin, at % 3) - numberAt(view.origin, at % 3));
}

/** Frames of the ghosts; null where the clip has none, or not yet. */
function ghostFrames(clip: Clip, frame: number): (number | null)[] {
  return GHOST_SECONDS.map((seconds) => {
    const at = frame + Math.round(seconds * clip.player.perSecond);
    return at >= 0 && at < clip.frames && clip.blocks.has(at) ? at : null;
  });
}

/** Lines of the selected points, or of hands and feet, a second before and after. */
function trailsOf(clip: Clip, frame: number, points: number[]): Float32Array[] {
  const { skeleton, player, frames } = clip;
  const chosen = points.length
    ? points
    : ["left_hand", "right_hand", "left_foot", "right_foot"]
        .map((name) => skeleton.byName.get(name) ?? -1)
        .filter((one) => one >= 0);
  const around = Math.round(TRAIL_SECONDS * player.perSecond);
  const step = Math.max(1, Math.round(player.perSecond / 60));
  return chosen.map((point) => {
    const line: number[] = [];
    for (let at = Math.max(0, frame - around); at <= Math.min(frames - 1, frame + around); at += step) {
      const positions = clip.blocks.has(at) ? clip.positions(at, false) : null;
      if (positions)
        line.push(
          numberAt(positions, point * 3),
          numberAt(positions, point * 3 + 1),
          numberAt(positions, point * 3 + 2),
        );
    }
    return Float32Array.from(line);
  });
}
