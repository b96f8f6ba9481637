"""Motions for tests: generated dances, files, and changed copies of either."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from mcml.formats import FORMATS, find_format
from mcml.formats.format import ReadOptions, SourceFile
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import convert
from mcml.motion.hub import HubReader
from mcml.motion.lexemes import triple
from mcml.motion.rotations import from_euler, multiply, rotate, slerp
from mcml.motion.skeleton import Array, Convention, EndSite, numbers
from mcml_service.analysis.interface import Motion
from mcml_service.demo.dance_clips import DanceClip, Style, Truth, dance_clip

STYLES: tuple[Style, ...] = get_args(Style)
BEAT_STYLES: tuple[Style, ...] = ("groove", "hit", "step", "accent")


def motion_of(clip: ClipStream, document: str = "1", name: str = "clip", frame_time: float | None = None) -> Motion:
    """A clip of any convention, or markers, as analyses get it."""
    markers = any(joint.convention is Convention.MARKER for joint in clip.head.skeleton.joints)
    listed = clip if markers else convert(clip, Convention.LISTED)
    reader = HubReader(listed.head.skeleton)
    blocks = [reader.read(block) for block in listed.blocks()]
    time = frame_time or clip.head.seconds_per_frame() or 1 / 120
    return Motion(
        document,
        1,
        name,
        listed.head.skeleton,
        time,
        np.concatenate([block.rotations for block in blocks]),
        np.concatenate([block.translations for block in blocks]),
        up="Y",
    )


def generated(style: Style = "groove", document: str = "1", **options: float | int) -> tuple[Motion, Truth]:
    """A generated dance and its truth."""
    made: DanceClip = dance_clip(style, **options)  # type: ignore[arg-type]
    return motion_of(made.clip, document, f"{style} {document}"), made.truth


def read_file(path: Path, document: str = "1") -> Motion:
    """A BVH or AMC file; an AMC with the skeleton whose name begins like its own. No rate: 120 frames a second."""
    data = path.read_bytes()
    format, part = find_format(path.name, data[:4096])
    files = {part: path}
    if part == "amc":
        stems = sorted(path.parent.glob("*.asf"), key=lambda item: _alike(item.stem.lower(), path.stem.lower()))
        files = {"asf": stems[-1], "amc": path}
    opened = {name: SourceFile(item.name, item.open("rb")) for name, item in files.items()}
    try:
        return motion_of(FORMATS[format.name].read(opened, ReadOptions()), document, path.stem)
    finally:
        for source in opened.values():
            source.stream.close()


def _alike(one: str, other: str) -> int:
    return next((place for place, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), len(one))


def moved(motion: Motion, heading: float, shift: Array) -> Motion:
    """The motion turned about Y and shifted as a whole; heading in radians."""
    turn = from_euler(np.array([heading]), "Y")
    roots = list(motion.skeleton.roots)
    rotations, translations = motion.rotations.copy(), motion.translations.copy()
    rotations[:, roots] = multiply(turn, rotations[:, roots])
    translations[:, roots] = rotate(turn, translations[:, roots]) + shift
    return replace(motion, rotations=rotations, translations=translations)


def enlarged(motion: Motion, factor: float) -> Motion:
    """The motion in another unit, which nobody states."""
    joints = tuple(
        replace(
            joint,
            offset=triple(numbers(joint.offset) * factor),
            end_sites=tuple(EndSite(triple(numbers(site.offset) * factor)) for site in joint.end_sites),
        )
        for joint in motion.skeleton.joints
    )
    return replace(
        motion,
        skeleton=replace(motion.skeleton, joints=joints),
        translations=motion.translations * factor,
    )


def resampled(motion: Motion, fps: float) -> Motion:
    """The motion at another frame rate, by lerp and slerp."""
    frames = np.arange(int((len(motion) - 1) / motion.fps * fps) + 1) / fps * motion.fps
    before = np.minimum(frames.astype(int), len(motion) - 2)
    part = frames - before
    rotations = slerp(
        motion.rotations[before],
        motion.rotations[before + 1],
        np.broadcast_to(part[:, None], motion.rotations[before].shape[:-1]),
    )
    low, high = motion.translations[before], motion.translations[before + 1]
    return replace(
        motion, frame_time=1 / fps, rotations=rotations, translations=low + (high - low) * part[:, None, None]
    )
