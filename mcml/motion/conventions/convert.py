"""Convert a clip to another convention, scale, or up axis.

Conversions keep positions exactly (to rounding); angles are copied where both conventions and orders allow it, else
decomposed again, continuous from frame to frame. Notices list losses with their size. Nothing is scaled or rotated
without a request (docs/conventions.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.conventions.blend_shapes import without_blend_shapes
from mcml.motion.conventions.plan_fixed import plan_fixed
from mcml.motion.conventions.plans import (
    FLIP,
    Plan,
    PlannedJoint,
    is_identity,
    is_within,
    plan_base,
    plan_listed,
    product_order,
)
from mcml.motion.conventions.resizing import scale, turn_axis, turn_up
from mcml.motion.conventions.survey import Survey, survey
from mcml.motion.extremes import within_doubles
from mcml.motion.hub import HubBlock, HubReader, Rest
from mcml.motion.markers import as_markers
from mcml.motion.rotations import IDENTITY, inverse, multiply, rotate, to_euler
from mcml.motion.skeleton import CHANNEL_INDEX, Array, Convention, Skeleton
from mcml.motion.units import DEGREES, Reading, metres_of, reading_of

__all__ = ["convert", "scale", "turn_axis", "turn_up", "with_scale_factor"]

_KEPT_FIELDS = ("filename", "skeleton_name", "dataframe_rate", "calibration_unit", "global_axis_of_gravity")
_SIGNS_OF_FLIP = {"X": 1.0, "Y": -1.0, "Z": -1.0}


def convert(clip: ClipStream, to: Convention, *, keep_translations: bool = False) -> ClipStream:
    """Convert a clip to another convention; return the same clip if it has that convention, and angles in degrees where
    its formats know no other unit.

    keep_translations: for FIXED, joints that move in their parent keep moving (`dof tx ty tz`, which few programs
    read); else they are fixed, with a notice. The frames are read once before, if joints may move in their parents. To
    MARKER: the positions of joints. Raises ConversionError for markers to anything else, as they have no skeleton, and
    for several roots to FIXED. Blend shapes are left out, with a notice.
    """
    clip = without_blend_shapes(clip)
    conventions = {joint.convention for joint in clip.head.skeleton.joints}
    if conventions <= {to} and not (to is Convention.LISTED and reading_of(clip.head) != DEGREES):
        return clip
    if Convention.MARKER in conventions:
        raise ConversionError(
            "markers have no skeleton: they cannot become joints", remedy="Export them as TRC, C3D or MCML."
        )
    if to is Convention.MARKER:
        return within_doubles(as_markers(clip))
    notices = clip.notices
    clip = with_scale_factor(clip)
    reading = reading_of(clip.head)
    found = survey(clip, reading)
    _report(clip.head, to, found, notices)
    skeleton = clip.head.skeleton
    if to is Convention.LISTED:
        plan = plan_listed(skeleton, found)
    elif to is Convention.BASE:
        plan = plan_base(skeleton, found)
    else:
        plan = plan_fixed(skeleton, found, keep_translations, notices)
    source = clip

    def blocks() -> Iterator[FrameBlock]:
        translator = _Translator(skeleton, reading, plan, to)
        for block in source.blocks():
            yield translator.translate(block)
        _report_missing(translator.missing, notices)

    return within_doubles(ClipStream(_head(clip.head, plan, to), blocks, clip.frames, notices))


def with_scale_factor(clip: ClipStream) -> ClipStream:
    """Multiply the lengths of a clip by the ScaleFactor of its file, as conversions do, with a notice."""
    factor = float(clip.head.fields.get("scale_factor", "1"))
    if factor == 1.0:
        return clip
    clip.notices.append(Notice("warning", f"lengths were multiplied by the file's ScaleFactor {factor}"))
    return scale(clip, factor)


def _head(head: ClipHead, plan: Plan, to: Convention) -> ClipHead:
    fields = {name: head.fields[name] for name in _KEPT_FIELDS if name in head.fields} | plan.fields
    if to is Convention.FIXED:
        metres = metres_of(head)
        # ASF's local unit is the inch wherever it is known at all.
        fields |= {"units_mass": "1.0", "units_length": repr(0.0254 / metres) if metres else "1.0"}
    return replace(head, skeleton=plan.skeleton, fields=fields, number_style="shortest", sources=())


def _report(head: ClipHead, to: Convention, found: Survey, notices: list[Notice]) -> None:
    joints = head.skeleton.joints
    if found.scaled:
        what = "tips of scaled bones differ" if to is not Convention.BASE else "stretched bones keep their rest length"
        notices.append(Notice("warning", f"the scale of bones cannot be written: joints are true, {what}"))
    lost = [
        name
        for name, present in (
            ("limits", any(joint.limits for joint in joints)),
            ("masses", any(joint.bodymass or joint.cofmass for joint in joints)),
        )
        if present
    ]
    if lost:
        notices.append(Notice("note", f"{' and '.join(lost)} of bones stay in the document, the target has no place"))


def _report_missing(missing: int, notices: list[Notice]) -> None:
    notice = Notice("warning", f"{missing} samples are missing; the last value is written")
    if missing and notice not in notices:
        notices.append(notice)


@dataclass
class _Angles:
    """How one joint gets its angles. columns, signs: of the source's values to copy by letter; None: decomposed."""

    letters: str
    copied: list[tuple[int, float] | None] | None


class _Translator:
    """Blocks of the source to blocks of the target; carries angles from block to block."""

    def __init__(self, skeleton: Skeleton, reading: Reading, plan: Plan, to: Convention) -> None:
        self._hub = HubReader(skeleton, reading)
        self._plan = plan
        self._to = to
        self._columns = plan.skeleton.columns()
        self._shapes = (full_shape(self._columns),)
        self._place = {column: index for index, column in enumerate(self._columns)}
        source_place = {column: index for index, column in enumerate(skeleton.columns())}
        self._angles = [
            _angles(planned, skeleton, self._hub.rest, source_place, plan.skeleton.joints[index].channels)
            for index, planned in enumerate(plan.joints)
        ]
        self._previous: list[Array | None] = [None] * len(plan.joints)
        degree = np.pi / 180
        self._to_degrees = None if reading.motion_angle == degree else reading.motion_angle / degree

    @property
    def missing(self) -> int:
        """How many samples had to be held so far."""
        return self._hub.missing

    def translate(self, block: FrameBlock) -> FrameBlock:
        hub = self._hub.read(block)
        values = np.zeros((len(block), len(self._columns)))
        for index, planned in enumerate(self._plan.joints):
            if planned.source is None:
                continue
            if planned.moves:
                moved = self._translation(planned, hub)
                for axis in range(3):
                    values[:, self._place[index, axis]] = moved[:, axis]
            self._write_angles(index, planned, hub, values)
            scale = self._place.get((index, CHANNEL_INDEX["SF"]))
            if scale is not None:
                values[:, scale] = 1.0
        return FrameBlock(values, self._columns, self._shapes, block.ids, None, block.motion_names)

    def _translation(self, planned: PlannedJoint, hub: HubBlock) -> Array:
        """Return (n, 3) for the target's channels."""
        assert planned.source is not None
        moved = hub.translations[:, planned.source]
        for other in planned.adds:
            moved = moved + hub.translations[:, other]
        if self._to is Convention.LISTED:
            return moved
        if planned.offset.any():
            moved = moved - planned.offset
        axes = planned.orientation if self._to is Convention.FIXED else self._above(planned)
        if planned.parent < 0 or is_identity(axes):
            return moved
        return rotate(inverse(axes), moved)

    def _above(self, planned: PlannedJoint) -> Array:
        return self._plan.joints[planned.parent].orientation if planned.parent >= 0 else IDENTITY

    def _write_angles(self, index: int, planned: PlannedJoint, hub: HubBlock, values: Array) -> None:
        angles = self._angles[index]
        columns = [self._place[index, CHANNEL_INDEX[f"R{letter.lower()}"]] for letter in angles.letters]
        if angles.copied is not None:
            for column, source in zip(columns, angles.copied, strict=True):
                if source is not None:
                    copied = hub.values[:, source[0]]
                    copied = copied if self._to_degrees is None else copied * self._to_degrees
                    values[:, column] = copied if source[1] > 0 else -copied
            return
        assert planned.source is not None
        turned = hub.rotations[:, planned.source]
        if not is_identity(planned.orientation):
            turned = multiply(multiply(inverse(planned.orientation), turned), planned.orientation)
        decomposed = to_euler(turned, angles.letters, self._previous[index])
        if len(decomposed):
            self._previous[index] = decomposed[-1]
        values[:, columns] = np.degrees(decomposed)


def _angles(
    planned: PlannedJoint,
    skeleton: Skeleton,
    rest: Rest,
    place: dict[tuple[int, int], int],
    channels: tuple[str, ...],
) -> _Angles:
    """Copied where the rest axes are the source's own, or half a turn about X from them, and the order fits."""
    letters = planned.order
    if planned.source is None or not letters:
        return _Angles("", [])
    order = product_order(skeleton.joints[planned.source])
    own = rest.orientations[planned.source]
    if not order:
        return _Angles(letters, [None] * len(letters))
    same = np.array_equal(planned.orientation, own) or (is_identity(planned.orientation) and is_identity(own))
    flipped = not same and np.array_equal(planned.orientation, multiply(own, FLIP))
    if not (same or flipped) or not is_within(order, letters):
        return _Angles(letters, None)
    copied: list[tuple[int, float] | None] = []
    for letter in letters:
        column = place.get((planned.source, CHANNEL_INDEX[f"R{letter.lower()}"])) if letter in order else None
        copied.append(None if column is None else (column, _SIGNS_OF_FLIP[letter] if flipped else 1.0))
    return _Angles(letters, copied)
