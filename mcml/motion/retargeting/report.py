"""The report of a retargeting: matched joints, errors of directions, sliding of feet."""

from __future__ import annotations

from dataclasses import dataclass

from mcml.errors import Notice
from mcml.motion.feet.locking import FootReport
from mcml.motion.retargeting.bone_mapping import Match
from mcml.motion.skeleton import Skeleton

_TOLD = 10.0
"""Mean error of hips or shoulders, in degrees, from which there is a warning."""


@dataclass(frozen=True)
class BoneError:
    """The error of the direction of a matched bone, in degrees: greatest and mean.

    joint, end: in the target. leads: whether the rotation of the joint follows this bone; where bones branch only one
    can, the others move with it.
    """

    joint: int
    end: int
    leads: bool
    largest: float
    mean: float
    frame: int = 0


@dataclass(frozen=True)
class AcrossError:
    """How far the line from the right to the left of `what` (hips, shoulders) points elsewhere, in degrees."""

    what: str
    largest: float
    mean: float


@dataclass(frozen=True)
class RetargetReport:
    """matches: the used matches.

    scale: of places. missing: joints of the source that no joint takes. extra: joints of the target that keep their
    rest pose. bones: directions. feet: contacts and sliding, empty without feet. across: of lines from right to left.
    """

    matches: tuple[Match, ...]
    scale: float
    missing: tuple[int, ...]
    extra: tuple[int, ...]
    bones: tuple[BoneError, ...]
    feet: tuple[FootReport, ...]
    across: tuple[AcrossError, ...] = ()

    def notices(self, source: Skeleton, target: Skeleton) -> list[Notice]:
        """The report as lines of a receipt."""
        lines = [Notice("note", f"{len(self.matches)} joints matched, places times {self.scale:.6g}")]
        for joints, skeleton, what in (
            (self.missing, source, "joints have no place in the target"),
            (self.extra, target, "joints of the target stay as at rest"),
        ):
            if joints:
                lines.append(Notice("note", f"{what}: {', '.join(skeleton.joints[index].name for index in joints)}"))
        worst = max((bone for bone in self.bones if bone.leads), key=lambda bone: bone.largest, default=None)
        if worst is not None and worst.largest > 1.0:
            name = target.joints[worst.joint].name
            lines.append(Notice("warning", f"{name!r} points up to {worst.largest:.1f} degrees elsewhere"))
        for foot in self.feet:
            if shortcomings := foot.shortcomings():
                lines.append(Notice("warning", f"{target.joints[foot.joint].name!r}: {'; '.join(shortcomings)}"))
        for line in self.across:
            if line.mean > _TOLD:
                told = f"the {line.what} point {line.mean:.0f} degrees elsewhere on the mean, up to {line.largest:.0f}"
                lines.append(Notice("warning", told))
        return lines
