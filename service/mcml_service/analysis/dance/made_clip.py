"""The clip of a new dance: its skeleton, properties and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mcml_service.analysis.dance.assembly import Dance
from mcml_service.analysis.dance.choreography import Plan
from mcml_service.analysis.dance.figure import lay_back
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
    plan: Plan,
    dance: Dance,
    fps: float,
    naming: Naming,
    motions: Sequence[Motion],
) -> MadeClip:
    """The new clip on the first clip's skeleton, with the axis up and the unit that clip has."""
    first = clips[0].motion
    original = min(motions, key=lambda motion: motion.document)
    laid = lay_back(replace(first, translations=dance.translations, rotations=dance.rotations), original.up)
    names = ", ".join(f"{clip.motion.name} (revision {clip.motion.revision})" for clip in clips)
    tempo = f"{naming.bpm:g} beats a minute" if naming.bpm else "the beats of music"
    return MadeClip(
        naming.name,
        original.skeleton,
        1 / fps,
        laid.rotations,
        laid.translations,
        metres=original.metres,
        up=original.up,
        description=f"{naming.bars} bars danced to {tempo}, made of {names}.",
        properties=_properties(clips, plan, naming),
        labels=_labels(plan, fps, len(dance.rotations), naming.labels),
    )


def _properties(clips: Sequence[Clip], plan: Plan, naming: Naming) -> tuple[tuple[str, str, str], ...]:
    sources = " ".join(f"{clip.motion.document}@{clip.motion.revision}" for clip in clips)
    tempo = (("tempo", f"{naming.bpm:g}", "bpm"),) if naming.bpm else ()
    return (
        *tempo,
        ("pulse", str(plan.pulse), ""),
        ("seed", str(naming.seed), ""),
        ("sources", sources, ""),
        ("path", " ".join(str(bar + 1) for bar in plan.path), ""),
        ("parameters", naming.parameters, ""),
    )


def _labels(plan: Plan, fps: float, frames: int, wanted: Sequence[str]) -> tuple[tuple[str, int, int], ...]:
    """Motion names of bars and beats on the frames nearest to the grid, from 0, both ends included."""
    edges = [min(frames, max(0, int(time * fps + 0.5))) for time in plan.grid]
    labels: list[tuple[str, int, int]] = []
    if "bars" in wanted:
        bars = enumerate(zip(edges[:-1:4], edges[4::4], strict=True), start=1)
        labels += [(f"bar-{number}", first, last - 1) for number, (first, last) in bars if first < last]
    if "beats" in wanted:
        labels += [("beat", frame, frame) for frame in edges[:-1] if frame < frames]
    return tuple(labels)
