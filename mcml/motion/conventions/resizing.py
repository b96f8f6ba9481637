"""A clip at another scale, or with another axis up, in the convention that it has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mcml.errors import ConversionError, Notice
from mcml.motion.calibration_properties import Properties, scale_values, turn_values
from mcml.motion.clip import ClipStream, FrameBlock, Shape
from mcml.motion.extremes import within_doubles
from mcml.motion.floor_plates import kept_plates, replace_plates
from mcml.motion.landmarks.sizes import PREFIX as MEASURES
from mcml.motion.lexemes import lexeme, triple
from mcml.motion.rotations import from_euler, from_fixed_euler, multiply, to_euler
from mcml.motion.skeleton import CHANNELS, TRANSLATIONS, Array, Convention, EndSite, Joint, Skeleton, Triple, numbers
from mcml.motion.units import Reading, reading_of

_LENGTHS = (*TRANSLATIONS, "residual")
"""Channels in the unit of length: the residual of a marker is measured as its coordinates are (c3d.org)."""


def scale(clip: ClipStream, factor: float, unit: str | None = None) -> ClipStream:
    """Multiply every length of a clip, also those that people set of its calibration.

    unit: the new unit, if the lengths are converted; else the size of the body changes, and measures of its subject
    are left out with a notice. Raises ConversionError for a
    factor that is not positive and finite.
    """
    if not (np.isfinite(factor) and factor > 0):
        raise ConversionError(f"{factor} is no factor of lengths", remedy="Give a positive number.")
    head = clip.head
    fields = dict(head.fields)
    if unit is not None:
        fields["calibration_unit"] = unit
        if "units_length" in fields:
            fields["units_length"] = lexeme(float(fields["units_length"]) * factor)
    joints = tuple(_scaled(joint, factor) for joint in head.skeleton.joints)
    properties = scale_values(head.properties, factor, resizes=unit is None)
    if unit is None and factor != 1.0:
        properties = _without_measures(properties, clip.notices)
    skeleton = replace(head.skeleton, joints=joints)
    head = replace(head, skeleton=skeleton, fields=fields, properties=properties, number_style="shortest")
    # A body of another size no longer fits the laboratory.
    plates = kept_plates(clip.head)
    head = replace_plates(head, plates[:0] if unit is None else plates * factor)
    conventions = [joint.convention for joint in joints]

    def blocks() -> Iterator[FrameBlock]:
        for block in clip.blocks():
            lengths = [
                CHANNELS[channel] in _LENGTHS or (channel == 6 and conventions[joint] is Convention.FIXED)
                for joint, channel in block.columns
            ]
            yield replace(block, values=block.values * np.where(lengths, factor, 1.0))

    original = None if clip.original is None else clip.original.scale(factor, resizes=unit is None)
    character = clip.character if isinstance(clip.character, bool) else clip.character.scale(factor)
    return within_doubles(replace(clip, head=head, blocks=blocks, original=original, character=character))


def _without_measures(properties: Properties, notices: list[Notice]) -> Properties:
    kept = tuple(item for item in properties if not item[0].startswith(MEASURES))
    if len(kept) < len(properties):
        notices.append(Notice("warning", "measures of the subject are left out: the body has another size"))
    return kept


def _scaled(joint: Joint, factor: float) -> Joint:
    def three(lexemes: Triple | None) -> Triple | None:
        return None if lexemes is None else triple(numbers(lexemes) * factor)

    def one(text: str | None) -> str | None:
        return None if text is None else lexeme(float(text) * factor)

    return replace(
        joint,
        offset=three(joint.offset),
        length=one(joint.length),
        cofmass=one(joint.cofmass),
        end_sites=tuple(replace(site, offset=triple(numbers(site.offset) * factor)) for site in joint.end_sites),
    )


def turn_up(clip: ClipStream, start: str, end: str) -> ClipStream:
    """Rotate a clip by a quarter turn so that its axis `start` (X, Y or Z), which is up, points where `end` did.

    The head states the new up axis. Otherwise as `turn_axis`.
    """
    turned = turn_axis(clip, start, end)
    fields = turned.head.fields | {"global_axis_of_gravity": end.upper()}
    return turned if turned is clip else turned.with_head(replace(turned.head, fields=fields))


def turn_axis(clip: ClipStream, start: str, end: str) -> ClipStream:
    """Rotate a clip by a quarter turn so that its axis `start` (X, Y or Z) points where `end` did.

    Angles of BVH only change axis and sign; those of ASF bones and of HTR stay, their rest axes turn instead.
    Raises ConversionError for an unknown axis.
    """
    for axis in (start, end):
        if axis.upper() not in ("X", "Y", "Z"):
            raise ConversionError(f"{axis!r} is no axis", remedy="Use X, Y or Z.")
    first, last = "XYZ".index(start.upper()), "XYZ".index(end.upper())
    if first == last:
        return clip
    turn = _Turn(first, last)
    head = clip.head
    reading = reading_of(head)
    joints = tuple(turn.joint(joint, reading) for joint in head.skeleton.joints)
    skeleton = replace(head.skeleton, joints=joints)

    def blocks() -> Iterator[FrameBlock]:
        for block in clip.blocks():
            yield turn.block(head.skeleton, block)

    properties = turn_values(head.properties, turn.rotation, turn.axes)
    head = replace(head, skeleton=skeleton, properties=properties, number_style="shortest")
    head = replace_plates(head, turn.points(kept_plates(head)))
    original = None if clip.original is None else clip.original.turn(turn.target, turn.sign)
    character = clip.character if isinstance(clip.character, bool) else clip.character.turn(turn.rotation)
    return replace(clip, head=head, blocks=blocks, original=original, character=character)


class _Turn:
    """A: a quarter turn that takes one axis to another, as a rotation and as a permutation with signs."""

    def __init__(self, first: int, last: int) -> None:
        third = 3 - first - last
        # The turn is about first x last, which is the third axis or its opposite.
        cyclic = (last - first) % 3 == 1
        angles = np.zeros(3)
        angles[third] = np.pi / 2 if cyclic else -np.pi / 2
        self.rotation = from_euler(angles, "XYZ")
        self.target = {first: last, last: first, third: third}
        self.sign = {first: 1.0, last: -1.0, third: 1.0}

    @property
    def axes(self) -> dict[str, str]:
        """Where each axis, such as "Y" or "-Z", points then."""
        told = {}
        for source, target in self.target.items():
            signs = ("", "-") if self.sign[source] > 0 else ("-", "")
            told["XYZ"[source]], told["-" + "XYZ"[source]] = (sign + "XYZ"[target] for sign in signs)
        return told

    def points(self, places: Array) -> Array:
        """(…, 3) turned."""
        turned = np.empty_like(places)
        for source, target in self.target.items():
            turned[..., target] = self.sign[source] * places[..., source]
        return turned

    def vector(self, lexemes: Triple | None) -> Triple | None:
        if lexemes is None:
            return None
        turned = ["", "", ""]
        for axis, text in enumerate(lexemes):
            turned[self.target[axis]] = text if self.sign[axis] > 0 else _negated(text)
        return turned[0], turned[1], turned[2]

    def turns_channels(self, joint: Joint) -> bool:
        """Tell whether the joint's channels themselves are rotated: those in world axes."""
        return joint.convention in (Convention.LISTED, Convention.MARKER) or joint.parent < 0

    def joint(self, joint: Joint, reading: Reading) -> Joint:
        if joint.convention is Convention.BASE:
            return self._base(joint, reading)
        if joint.convention is Convention.FIXED and joint.parent >= 0:
            axes = from_fixed_euler(numbers(joint.axis) * reading.rest_angle, joint.axis_order or "XYZ")
            order = (joint.axis_order or "XYZ").upper()
            angles = to_euler(multiply(self.rotation, axes)[None], order[::-1])[0][::-1] / reading.rest_angle
            return replace(
                joint, direction=self.vector(joint.direction), axis=triple(angles), axis_order=joint.axis_order or "XYZ"
            )
        turned = replace(
            joint,
            offset=self.vector(joint.offset),
            channels=self._channels(joint.channels, True, True),
            rotation_order="".join("XYZ"[self.target["XYZ".index(letter)]] for letter in joint.rotation_order.upper()),
            end_sites=tuple(
                EndSite(self.vector(site.offset) or site.offset, site.name, site.before) for site in joint.end_sites
            ),
        )
        if joint.axis is None or not numbers(joint.axis).any():
            return turned
        # A root turned at rest: C becomes A C A^-1, whose angles only change axis and sign.
        order = (joint.axis_order or "XYZ").upper()
        letters = "".join("XYZ"[self.target["XYZ".index(letter)]] for letter in order)
        signed = tuple(
            text if self.sign["XYZ".index(letter)] > 0 else _negated(text)
            for letter, text in zip(order, joint.axis, strict=True)
        )
        return replace(turned, axis=(signed[0], signed[1], signed[2]), axis_order=letters)

    def _base(self, joint: Joint, reading: Reading) -> Joint:
        if joint.parent >= 0:
            return joint
        order = (joint.axis_order or joint.rotation_order or "ZYX").upper()
        places = ["XYZ".index(letter) for letter in order]
        own = from_euler(numbers(joint.axis)[places] * reading.rest_angle, order)
        turned = to_euler(multiply(self.rotation, own)[None], order)[0] / reading.rest_angle
        angles = np.zeros(3)
        angles[places] = turned
        return replace(
            joint,
            offset=self.vector(joint.offset),
            axis=triple(angles),
            axis_order=order,
            channels=self._channels(joint.channels, True, False),
        )

    def _channels(self, channels: tuple[str, ...], translations: bool, rotations: bool) -> tuple[str, ...]:
        """Channels under their new axes; translations stay in the order of the axes where they were in it."""
        named = []
        for channel in channels:
            turns = (channel[0] == "T" and translations) or (channel[0] == "R" and rotations)
            named.append(channel[0] + "xyz"[self.target["xyz".index(channel[1])]] if turns else channel)
        moved = sorted(channel for channel in named if channel[0] == "T")
        return tuple(moved.pop(0) if channel[0] == "T" else channel for channel in named)

    def block(self, skeleton: Skeleton, block: FrameBlock) -> FrameBlock:
        columns, signs = [], []
        for joint, channel in block.columns:
            axis = self._axis_of(skeleton.joints[joint], channel)
            columns.append((joint, channel if axis is None else channel - axis + self.target[axis]))
            signs.append(1.0 if axis is None else self.sign[axis])
        negative = np.flatnonzero(np.array(signs) < 0)
        values = block.values.copy()
        values[:, negative] = -values[:, negative]
        shapes = tuple(self._shape(skeleton, shape) for shape in block.shapes)
        return replace(block, values=values, columns=tuple(columns), shapes=shapes)

    def _axis_of(self, joint: Joint, channel: int) -> int | None:
        """The axis that a channel is about, None where the channel is not turned."""
        if channel > 5 or not self.turns_channels(joint):
            return None
        if channel > 2 and joint.convention is Convention.BASE:
            return None
        return channel % 3

    def _shape(self, skeleton: Skeleton, shape: Shape) -> Shape:
        turned = []
        for joint, bits in shape:
            moved = 0
            for channel in range(len(CHANNELS)):
                if bits >> channel & 1:
                    axis = self._axis_of(skeleton.joints[joint], channel)
                    moved |= 1 << (channel if axis is None else channel - axis + self.target[axis])
            turned.append((joint, moved))
        return tuple(turned)


def _negated(text: str) -> str:
    """The lexeme of the opposite number."""
    if text.startswith("-"):
        return text[1:]
    return text if not float(text) else "-" + text.removeprefix("+")
