"""Angles of a body under the names of columns, block by block, bit by bit as in queries.

They come from positions rounded as there (0.1 mm of a person). Angles that need the up axis exist only if the document
states it: guesses are used in queries, but never written to a file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mcml.errors import ConversionError
from mcml.formats.format import note
from mcml.motion.anatomy.axes import Stance
from mcml.motion.bodies.bone_axes import line_steps
from mcml.motion.bodies.clip_body import calibrate_clip
from mcml.motion.bodies.limb_angles import ANGLES, NEEDS_ROTATIONS, angle_named
from mcml.motion.bodies.positions import rounded, world_positions
from mcml.motion.bodies.reference import stance_of
from mcml.motion.bodies.stretch import Stretch, known
from mcml.motion.bodies.turned_angles import turned_angle
from mcml.motion.clip import ClipStream, FrameBlock
from mcml.motion.hub import rest_of
from mcml.motion.kinematics import Walker, unseen
from mcml.motion.layout import Held
from mcml.motion.skeleton import Array
from mcml.motion.units import reading_of

OPPOSITES: Final = frozenset(
    (
        *("extension", "adduction", "horizontal-adduction", "plantarflexion", "left-lateral-flexion", "right-rotation"),
        *("posterior-tilt", "depression", "retraction", "lateral-rotation", "supination", "eversion"),
    )
)
"""Movements that are the opposite of another one: it has the column, with the other sign."""

UPRIGHT: Final = frozenset(
    (
        ("trunk", "flexion"),
        ("trunk", "right-lateral-flexion"),
        ("pelvis", "right-lateral-flexion"),
    )
)
"""(part, movement): angles between joints that take the up axis. All that need rotations do."""

_MIDDLE: Final = ("trunk", "pelvis", "head", "neck")
_SUFFIXES: Final = {"left": "_l", "right": "_r", "": ""}


@dataclass(frozen=True)
class Column:
    """A column of angles.

    name: as in queries, `left-knee-flexion`. title: as in the file, `knee_flexion_l`. turned: whether it needs
    rotations; upright: whether it needs the up axis.
    """

    name: str
    title: str
    turned: bool
    upright: bool


def all_columns() -> list[Column]:
    """Every angle that a file may have, in its order."""
    named = [(part, movement, False) for part, movement in ANGLES]
    named += [(part, movement, True) for part, movements in NEEDS_ROTATIONS.items() for movement in movements]
    columns = []
    for part, movement, turned in named:
        if movement in OPPOSITES:
            continue
        for side in ("",) if part in _MIDDLE else ("right", "left"):
            name = "-".join(word for word in (side, part, movement) if word)
            title = f"{part}_{movement}".replace("-", "_") + _SUFFIXES[side]
            columns.append(Column(name, title, turned, turned or (part, movement) in UPRIGHT))
    return columns


class BodyAngles:
    """The angles that the body of a clip has. columns: those, in order. frames: of the clip."""

    def __init__(self, clip: ClipStream) -> None:
        """Reads the frames a few times. Raises ConversionError for a body none of whose angles is known."""
        self._clip = clip
        head = clip.head
        self._reading = reading_of(head)
        self.frames = clip.frames if clip.frames is not None else sum(len(block) for block in clip.blocks())
        possible = all_columns()
        between = [column for column in possible if not column.turned and _has(column, head.skeleton.names)]
        # A pose before the motion is a guess too: its angles are written.
        self._calibration = replace(calibrate_clip(clip, self.frames), skipped=0)
        stated = self._calibration.origins["up"].kind == "stated"
        self._stance = self._reference() if stated else None
        turned = [column for column in possible if column.turned and self._turns(column)]
        self.columns = [column for column in between if stated or not column.upright] + turned
        self._leave_out_unknown()
        left_out = [column.title for column in between if column.upright and not stated]
        if left_out or (not stated and between):
            what = f"{', '.join(left_out)} and turns from the reference pose" if left_out else "turns"
            note(clip.notices, "note", f"the document states no up axis: {what} are left out")
        if not self.columns:
            raise ConversionError(
                "no angle of this body is known: its joints are no hips, knees or elbows",
                remedy="Give joints MCML's names first, or export them as TRC.",
            )

    def _leave_out_unknown(self) -> None:
        """No columns of nothing but nan, such as how far arms are spread forwards that are never raised."""
        if not self.frames:
            return
        seen = np.zeros(len(self.columns), dtype=bool)
        for degrees in self.blocks():
            seen |= np.isfinite(degrees).any(axis=0)
            if seen.all():
                return
        unknown = [column.title for column, known in zip(self.columns, seen, strict=True) if not known]
        self.columns = [column for column, known in zip(self.columns, seen, strict=True) if known]
        note(self._clip.notices, "note", f"left out, as no frame tells them: {', '.join(unknown)}")

    def blocks(self) -> Iterator[Array]:
        """Degrees (n, K) of consecutive frames, NaN where unknown."""
        skeleton = self._clip.head.skeleton
        between = [angle_named(column.name) for column in self.columns if not column.turned]
        turned = [column.name for column in self.columns if column.turned]
        walker, rest = Walker(skeleton, self._reading), rest_of(skeleton, self._reading)
        if not self.columns:
            return
        for block, values, positions in self._place_blocks():
            steps = rounded(positions, self._calibration.step)
            places = {joint.name: steps[:, index] for index, joint in enumerate(skeleton.joints)}
            lines, sides = line_steps(skeleton, self._calibration.bones, positions, values, self._reading)
            places |= {line: sides[:, index] for index, line in enumerate(lines)}
            stretch = Stretch(places, len(block), None, self._calibration)
            found = [angle.compute(stretch, side) for angle, side in between]
            if turned and self._stance is not None:
                rotations = walker.poses(block)[1]
                gaps = np.asarray(np.isnan(positions).any(axis=2))
                found += [turned_angle(name, skeleton, rest, self._stance, rotations, gaps) for name in turned]
            yield np.stack(found, axis=1)

    def _place_blocks(self) -> Iterator[tuple[FrameBlock, Array, Array]]:
        """Blocks with values (n, D), and positions (n, J, 3), NaN where a sample is missing."""
        skeleton = self._clip.head.skeleton
        held = Held(skeleton)
        for block in self._clip.blocks():
            if not len(block):
                continue
            before = held.missing
            values = held.values(block)
            positions = world_positions(skeleton, values, self._reading)
            if held.missing > before:
                positions = np.array(positions)
                positions[unseen(skeleton, block)] = np.nan
            yield block, values, positions

    def _reference(self) -> Stance | None:
        """The pose from which rotations start; None if it is unknown, or if left and right are unknown in it."""
        try:
            return stance_of(self._calibration.start, self._clip.head.skeleton, self._reading)
        except ConversionError:
            return None

    def _turns(self, column: Column) -> bool:
        """Whether the body has the part of an angle that needs rotations."""
        if self._stance is None:
            return False
        skeleton = self._clip.head.skeleton
        rest = rest_of(skeleton, self._reading)
        found = turned_angle(column.name, skeleton, rest, self._stance, self._stance.turned[None])
        return bool(np.isfinite(found).all())


def _has(column: Column, joints: tuple[str, ...]) -> bool:
    angle, side = angle_named(column.name)
    return all(known(one, joints) is not None for one in angle.joints(side))
