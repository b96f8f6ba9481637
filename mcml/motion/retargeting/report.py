"""The report of a retargeting: matched joints, errors of directions, sliding of feet."""

from __future__ import annotations

from dataclasses import dataclass

from mcml.errors import Notice
from mcml.motion.feet.locking import FootReport
from mcml.motion.retargeting.bone_mapping import Match
from mcml.motion.retargeting.hand_contacts import HandContact
from mcml.motion.retargeting.limits import ClampedJoint
from mcml.motion.skeleton import Skeleton

_TOLD = 10.0
"""Mean error of a part of the body, in degrees, from which there is a warning."""


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
class PartError:
    """How far a part of the body points elsewhere, in degrees: greatest and mean.

    what: a limb ("left arm"), "hips" and "shoulders" (the lines from right to left), "trunk" or "head". joint: of the
    target, where the part begins; of a limb the bone that points farthest elsewhere.
    """

    what: str
    joint: int
    largest: float
    mean: float
    frame: int = 0


@dataclass(frozen=True)
class RetargetReport:
    """matches: the used matches.

    scale: of places. missing: joints of the source that no joint takes. extra: joints of the target that keep their
    rest pose. bones: directions. feet: contacts and sliding, empty without feet. parts: directions of limbs, hips,
    shoulders, trunk and head, as far as their joints are matched. travel: factor of places along the ground. clamped:
    joints kept inside limits. beyond: joints that planted feet or held hands take outside their limits again. hands:
    contacts of hands that were kept.
    """

    matches: tuple[Match, ...]
    scale: float
    missing: tuple[int, ...]
    extra: tuple[int, ...]
    bones: tuple[BoneError, ...]
    feet: tuple[FootReport, ...]
    parts: tuple[PartError, ...] = ()
    travel: float = 1.0
    clamped: tuple[ClampedJoint, ...] = ()
    beyond: tuple[ClampedJoint, ...] = ()
    hands: tuple[HandContact, ...] = ()

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
        for part in self.parts:
            if part.mean > _TOLD:
                verb = "point" if part.what.endswith("s") else "points"
                lines.append(
                    Notice(
                        "warning",
                        f"the {part.what} {verb} {part.mean:.0f} degrees elsewhere on the mean, up to "
                        f"{part.largest:.0f} ({target.joints[part.joint].name!r})",
                    )
                )
        return lines + self._about_limits(target) + self._about_hands(target)

    def _about_limits(self, target: Skeleton) -> list[Notice]:
        lines = [
            Notice(
                "note",
                f"{target.joints[each.joint].name!r} is kept inside its limits in {_count(each.spans)} frames, by up "
                f"to {each.largest:.1f} degrees",
            )
            for each in self.clamped
        ]
        return lines + [
            Notice(
                "warning",
                f"{target.joints[each.joint].name!r} is up to {each.largest:.1f} degrees outside its limits, because "
                f"planted feet or hand contacts are kept",
            )
            for each in self.beyond
        ]

    def _about_hands(self, target: Skeleton) -> list[Notice]:
        return [
            Notice(
                "warning",
                f"{target.joints[each.hand].name!r} misses its place at {target.joints[each.other].name!r} by up to "
                f"{each.after:.3g} in frames {each.first + 1} to {each.last + 1}",
            )
            for each in self.hands
            if each.is_missed
        ]


def _count(spans: tuple[tuple[int, int], ...]) -> int:
    return sum(last - first + 1 for first, last in spans)
