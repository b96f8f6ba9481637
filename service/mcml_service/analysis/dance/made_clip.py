"""The clip of a new dance: its skeleton, properties and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcml.motion.skeleton import Array, Skeleton
from mcml_service.analysis.dance.figure import lay_back
from mcml_service.analysis.dance.group_dance.dancers import Dancer
from mcml_service.analysis.dance.sources import Clip
from mcml_service.analysis.interface import MadeClip, Motion


@dataclass(frozen=True)
class Naming:
    """The parameters of a dance that its clip states. bpm: None for music. parameters: JSON of those that were given.

    labels: "bars", "beats".
    """

    name: str
    bars: int
    bpm: float | None
    seed: int
    parameters: str
    labels: Sequence[str]


def make_clip(
    clips: Sequence[Clip],
    dancers: Sequence[Dancer],
    grid: Array,
    fps: float,
    naming: Naming,
    motions: Sequence[Motion],
) -> MadeClip:
    """The new clip on the first clip's skeleton, with the axis up and the unit that clip has.

    Of several dancers it has one body each. grid: (4 M + 1,) motion beats of the whole dance.
    """
    first = clips[0].motion
    original = min(motions, key=lambda motion: motion.document)
    laid = [
        lay_back(replace(first, translations=one.dance.translations, rotations=one.dance.rotations), original.up)
        for one in dancers
    ]
    group = f" by {len(dancers)} dancers" if len(dancers) > 1 else ""
    names = ", ".join(f"{clip.motion.name} (revision {clip.motion.revision})" for clip in clips)
    tempo = f"{naming.bpm:g} beats a minute" if naming.bpm else "the beats of music"
    return MadeClip(
        naming.name,
        join_bodies(original.skeleton, len(dancers)),
        1 / fps,
        np.concatenate([body.rotations for body in laid], axis=1),
        np.concatenate([body.translations for body in laid], axis=1),
        metres=original.metres,
        up=original.up,
        description=f"{naming.bars} bars danced{group} to {tempo}, made of {names}.",
        properties=_properties(clips, dancers, naming),
        labels=_labels(grid, fps, len(laid[0]), naming.labels),
    )


def join_bodies(skeleton: Skeleton, count: int) -> Skeleton:
    """A skeleton of several equal bodies, joints of the n-th one named `dancern:` and their name; of one as it is."""
    if count == 1:
        return skeleton
    joints, size = [], len(skeleton)
    for body in range(count):
        prefix = f"dancer{body + 1}:"
        joints += [
            replace(
                joint,
                name=prefix + joint.name,
                source_name=prefix + joint.source_name,
                parent=joint.parent + body * size if joint.parent >= 0 else -1,
                mapped=False,
                confidence=None,
            )
            for joint in skeleton.joints
        ]
    declared = tuple(joint + body * size for body in range(count) for joint in skeleton.declared)
    return Skeleton(tuple(joints), declared)


def _properties(clips: Sequence[Clip], dancers: Sequence[Dancer], naming: Naming) -> tuple[tuple[str, str, str], ...]:
    sources = " ".join(f"{clip.motion.document}@{clip.motion.revision}" for clip in clips)
    paths = [" ".join(str(bar + 1) for bar in dancer.plan.path) for dancer in dancers]
    tempo = (("tempo", f"{naming.bpm:g}", "bpm"),) if naming.bpm else ()
    return (
        *tempo,
        ("pulse", str(dancers[0].plan.pulse), ""),
        ("seed", str(naming.seed), ""),
        ("sources", sources, ""),
        ("path", paths[0], ""),
        *((f"path {number}", path, "") for number, path in enumerate(paths[1:], start=2) if path != paths[0]),
        ("parameters", naming.parameters, ""),
    )


def _labels(grid: Array, fps: float, frames: int, wanted: Sequence[str]) -> tuple[tuple[str, int, int], ...]:
    """Motion names of bars and beats on the frames nearest to the grid, from 0, both ends included."""
    edges = [min(frames, max(0, int(time * fps + 0.5))) for time in grid]
    labels: list[tuple[str, int, int]] = []
    if "bars" in wanted:
        bars = enumerate(zip(edges[:-1:4], edges[4::4], strict=True), start=1)
        labels += [(f"bar-{number}", first, last - 1) for number, (first, last) in bars if first < last]
    if "beats" in wanted:
        labels += [("beat", frame, frame) for frame in edges[:-1] if frame < frames]
    return tuple(labels)
