"""A clip made fit for its target: a range of its frames, in place, another frame rate, another size."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError, RequestError
from mcml.formats import WRITERS
from mcml.formats.format import note
from mcml.motion.bodies.clip_body import body_of
from mcml.motion.bodies.stature import find_stature
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock
from mcml.motion.conventions.convert import scale
from mcml.motion.edits.in_place import stay_in_place
from mcml.motion.edits.resampling import resampled
from mcml.motion.frames import joined, rows_of
from mcml.motion.lexemes import lexeme
from mcml.motion.units import metres_of, reading_of


@dataclass(frozen=True)
class Reshaping:
    """first, last: frames from 1, both included. in_place: without travel over the ground. fps: frames a second. scale:
    factor of all lengths of the body. height: metres that the body stands tall, instead of a factor.
    """

    first: int = 1
    last: int | None = None
    in_place: bool = False
    fps: float | None = None
    scale: float | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        if self.scale is not None and self.height is not None:
            raise RequestError("Both a scale and a height are given.", remedy="Give one of them.")


def parse_range(text: str | None) -> tuple[int, int | None]:
    """FIRST-LAST, FIRST- or -LAST as positions from 1. RequestError for anything else.

    >>> parse_range("10-20"), parse_range("5-"), parse_range(None)
    ((10, 20), (5, None), (1, None))
    """
    if text is None:
        return 1, None
    match = re.fullmatch(r"\s*(\d{0,12})\s*-\s*(\d{0,12})\s*", text)
    first, last = (int(match[1] or 1), int(match[2]) if match[2] else None) if match else (0, None)
    if first < 1 or (last is not None and last < first):
        raise RequestError(f"{text!r} is no range of frames.", remedy="Write FIRST-LAST, such as 1-120, from 1.")
    return first, last


def reshape(clip: ClipStream, reshaping: Reshaping, up: str | None = None) -> ClipStream:
    """The range, in place, at the rate, scaled; not yet of a height, which `fit_height` gives once units are those of
    the file.

    up: the axis that points up; default that of its body. Raises ConversionError where the clip has no such frames, or
    no rate.
    """
    if reshaping.in_place and up is None:
        up = body_of(clip.head, clip.blocks()).calibration.up
    if reshaping.first > 1 or reshaping.last is not None:
        clip = _cut(clip, reshaping.first, reshaping.last)
    if reshaping.in_place and up is not None:
        clip = _keep_in_place(clip, up)
    if reshaping.fps is not None:
        clip = _resample(clip, reshaping.fps)
    if reshaping.scale is not None:
        clip = scale(clip, reshaping.scale)
    return clip


def fit_height(clip: ClipStream, height: float | None, *, guesses: bool = True) -> ClipStream:
    """Scale a clip so that its body stands so many metres tall; None leaves it.

    guesses: False refuses where the unit is not stated. Raises ConversionError where it is not known, and for bodies
    without legs.
    """
    if height is None:
        return clip
    if not (np.isfinite(height) and height > 0):
        raise RequestError(f"{height} is no height.", remedy="Give metres, such as 1.75.")
    calibration = body_of(clip.head, clip.blocks()).calibration
    stature = find_stature(clip.head.skeleton, reading_of(clip.head), calibration)
    if stature is None or calibration.metres is None:
        what = "height of its body" if stature is None else "unit of length"
        raise ConversionError(
            f"The {what} is not known, so it cannot be scaled to {height:g} m.", remedy="Give a factor, `scale`."
        )
    guessed = calibration.origins["metres"].kind == "guessed"
    if guessed and not guesses:
        raise ConversionError("The unit of length is a guess, and guesses are not wanted.", remedy="State the unit.")
    now = stature.height * calibration.metres
    factor = height / now
    kind = "guess" if guessed or stature.kind == "guessed" else "note"
    note(
        clip.notices,
        kind,
        f"the body stands {now:.3g} m tall ({stature.reason}): scaled by {factor:.4g} for {height:g} m",
    )
    return scale(clip, factor)


def _keep_in_place(clip: ClipStream, up: str) -> ClipStream:
    head = clip.head
    block = joined(clip.blocks())
    if not len(block):
        return clip
    edited = stay_in_place(head.skeleton, block, 0, len(block) - 1, up.lstrip("-"), reading_of(head))
    clip.notices.extend(edited.shortfall.notices(head.skeleton))
    return replace(clip, blocks=lambda: iter([edited.block]), frames=len(block))


def need_stated_facts(head: ClipHead, name: str) -> None:
    """Raises ConversionError where a format would have to guess the unit or the up axis of a document."""
    if not WRITERS[name].assumes:
        return
    missing = [] if metres_of(head) is not None else ["unit"]
    missing += [] if head.fields.get("global_axis_of_gravity") else ["up axis"]
    if missing:
        raise ConversionError(
            f"The document states no {' and no '.join(missing)}, and guesses are not wanted.",
            remedy="State them with `unit` and `up`, or allow guesses.",
        )


def _cut(clip: ClipStream, first: int, last: int | None) -> ClipStream:
    if clip.frames is not None and first > clip.frames:
        raise ConversionError(
            f"The clip has {clip.frames} frames, none from {first} on.", remedy="Give an earlier first frame."
        )

    def blocks() -> Iterator[FrameBlock]:
        at = 0
        for block in clip.blocks():
            start, end = max(first - 1 - at, 0), len(block) if last is None else min(len(block), last - at)
            at += len(block)
            if start < end:
                yield rows_of(block, start, end)
            if last is not None and at >= last:
                return

    frames = None if clip.frames is None else min(last or clip.frames, clip.frames) - first + 1
    return replace(clip, blocks=blocks, frames=frames)


def _resample(clip: ClipStream, fps: float) -> ClipStream:
    head = clip.head
    seconds = head.seconds_per_frame()
    if seconds is None:
        raise ConversionError("The clip states no frame time, so its rate cannot be changed.", remedy="State it.")
    if not (np.isfinite(fps) and fps > 0):
        raise RequestError(f"{fps} is no frame rate.", remedy="Give frames a second, such as 30.")
    edited = resampled(head.skeleton, joined(clip.blocks()), seconds, 1 / fps, reading_of(head))
    fields = {name: text for name, text in head.fields.items() if name != "dataframe_rate"}
    head = replace(head, frame_time=lexeme(1 / fps), fields=fields)
    original = None if clip.original is None else replace(clip.original, is_resampled=True)
    made = edited.block
    return replace(clip, head=head, blocks=lambda: iter([made]), frames=len(made), original=original)
