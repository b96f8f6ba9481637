"""Data that a written C3D file takes from the file that its frames came from.

Analog samples follow their frames, by the numbers that the frames have in the file. Force plates, subjects and other
groups of parameters are written again. See docs/formats/c3d.md.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError, LimitError, Notice
from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.parameters import INTEL, Machine, Parameter
from mcml.formats.c3d.plates import plates_of
from mcml.formats.c3d.records import copy_record, fits_record, float_record, group_record, word_record
from mcml.formats.c3d.rotations import count_rotations
from mcml.formats.format import note
from mcml.motion.clip import Original
from mcml.motion.skeleton import Array

Ids = NDArray[np.int64] | list[str]

ANALOG, PLATES, TRIAL = "ANALOG", "FORCE_PLATFORM", "TRIAL"
_OWN: Final = frozenset({"", "POINT", "EVENT", ANALOG, PLATES, TRIAL})
"""Groups that the writer writes itself, in part from those of the file."""

_OF_OTHER_DATA: Final = frozenset({"ROTATION", "DATA_BLOCKS"})
"""Groups that describe data which are not written."""

_FIRST_OTHER, _LAST_GROUP = 6, 127
_SAME_RATE: Final = 1e-4
"""Relative difference of two statements of one rate, which rounding does not reach."""

_MOST_RATE: Final = 3e38
_MOST_VALUES: Final = 0xFFFF
"""Analog values of a frame are counted in a word of the header."""

_MOST_SIGNED: Final = 32_767
_DESCRIPTIONS: Final = re.compile(r"DESCRIPTIONS\d*")
_OFFSETS: Final = re.compile(r"OFFSET\d*")
_LENGTHS: Final = re.compile(r"(CORNERS|ORIGIN)\d*")

Groups = dict[str, dict[str, Parameter]]
"""Parameters by group and name in capitals."""


@dataclass(frozen=True, eq=False)
class OriginalData:
    """channels: whose samples are written, None for none. groups: to write again.

    shifts: (channels,) what stored numbers are reduced by, because their offsets were.
    """

    channels: Channels | None = None
    groups: Groups = field(default_factory=dict)
    shifts: Array | None = None

    @property
    def values(self) -> int:
        """Analog values of a frame."""
        return 0 if self.channels is None else len(self.channels) * self.channels.samples

    @property
    def samples(self) -> int:
        """Samples of a channel in a frame, 0 without channels."""
        return 0 if self.channels is None else self.channels.samples

    def count_unknown(self, ids: Ids) -> int:
        """How many of these frames are not of the file."""
        return 0 if self.channels is None else int((self._places(ids) < 0).sum())

    def add_samples(self, points: bytes, ids: Ids) -> Iterator[bytes]:
        """Return the frames with their analog samples, which are NaN in frames that are not of the file.

        points: the bytes of the points of these frames.
        """
        channels = self.channels
        if channels is None or not len(ids):
            yield points
            return
        rows = np.frombuffer(points, np.uint8).reshape(len(ids), -1)
        places = self._places(ids)
        # Numbers are doubles while they are read.
        count = max(1, channels.block // 4)
        for first in range(0, len(places), count):
            some = places[first : first + count]
            analog = self._read(channels, some).view(np.uint8)
            yield np.concatenate([rows[first : first + len(some)], analog], axis=1).tobytes()

    def records(self, first: int, frames: int, rate: float, *, is_long: bool) -> list[bytes]:
        """Return the records of ANALOG, FORCE_PLATFORM, TRIAL and of the groups of the file's own.

        first: number of the first frame. rate: frames a second. is_long: whether there are more than 65,535 frames.
        """
        channels, last = self.channels, first + frames - 1
        count = 0 if channels is None else len(channels)
        records = [group_record(2, ANALOG), word_record(2, "USED", count)]
        if channels is not None:
            stated = channels.rate if math.isfinite(channels.rate) else rate * channels.samples
            records.append(float_record(2, "RATE", min(stated, _MOST_RATE)))
        records += self._copies(2, ANALOG)
        records.append(group_record(3, PLATES))
        if "USED" not in self.groups.get(PLATES, {}):
            records.append(word_record(3, "USED", self._count_plates()))
        records += self._copies(3, PLATES)
        if is_long or TRIAL in self.groups:
            records.append(group_record(4, TRIAL))
            for name, number in (("ACTUAL_START_FIELD", first), ("ACTUAL_END_FIELD", last)):
                words = np.array([number & 0xFFFF, number >> 16], "<u2").tobytes()
                records.append(copy_record(4, name, Parameter(2, (2,), words, _MACHINE)))
            records += self._copies(4, TRIAL)
        others = [name for name in self.groups if name not in _OWN]
        for number, name in enumerate(others[: _LAST_GROUP - _FIRST_OTHER + 1], _FIRST_OTHER):
            spelling = next(iter(self.groups[name].values())).spelling.partition(":")[0]
            records += [group_record(number, spelling or name), *self._copies(number, name)]
        return records

    def lighter(self, notices: list[Notice]) -> Iterator[OriginalData]:
        """Return the data, then less and less of them, each time with a notice: parameters have little room."""
        yield self
        if any(_DESCRIPTIONS.fullmatch(name) for group in self.groups.values() for name in group):
            note(notices, "warning", "descriptions of the source file are left out: parameters have no room for them")
            data = replace(self, groups=_select(self.groups, lambda _, name: not _DESCRIPTIONS.fullmatch(name)))
            yield data
        else:
            data = self
        others = [name for name in data.groups if name not in _OWN]
        if others:
            named = ", ".join(others)[:200]
            note(notices, "warning", f"groups of the source file are left out ({named}): the parameters have no room")
            data = replace(data, groups=_select(data.groups, lambda group, _: group in _OWN))
            yield data
        if data.channels is not None:
            what = f"{len(data.channels)} analog channels are left out: the parameters have no room for them"
            note(notices, "warning", what)
            yield OriginalData()

    def _count_plates(self) -> int:
        return 0 if self.channels is None or PLATES not in self.groups else len(plates_of(self.channels))

    def _copies(self, number: int, group: str) -> list[bytes]:
        return [copy_record(number, name, part) for name, part in self.groups.get(group, {}).items()]

    def _places(self, ids: Ids) -> NDArray[np.int64]:
        """(n,) places of frames in the file, -1 for frames that are not of the file."""
        numbers = np.asarray(ids)
        if self.channels is None or numbers.dtype.kind != "i":
            return np.full(len(ids), -1, np.int64)
        places = numbers - self.channels.first
        return np.where((places >= 0) & (places < self.channels.frames), places, -1)

    def _read(self, channels: Channels, places: NDArray[np.int64]) -> NDArray[np.float32]:
        """(n, values of a frame) stored numbers of frames, NaN where the place is -1."""
        values = np.full((len(places), self.values), np.nan, "<f4")
        is_known = places >= 0
        wanted, order = np.unique(places[is_known], return_inverse=True)
        rows = np.empty((len(wanted), self.values), "<f4")
        for run in np.split(np.arange(len(wanted)), np.flatnonzero(np.diff(wanted) > 1) + 1):
            if len(run):
                raw = channels.read_raw(int(wanted[run[0]]), len(run))
                if self.shifts is not None:
                    raw -= self.shifts
                rows[run] = raw.reshape(len(run), -1)
        values[is_known] = rows[order]
        return values


def read_original(original: Original | None, rate: float, unit: str, notices: list[Notice]) -> OriginalData:
    """Read the data that a file of these frames a second and this unit of length takes from the original, with notices.

    Nothing where there is no original, or where it cannot be read any more.
    """
    if original is None:
        return OriginalData()
    try:
        channels: Channels = original.read_channels()
    except (FormatError, LimitError) as error:
        note(notices, "warning", f"analog channels and groups of the source file are left out: {error}")
        return OriginalData()
    groups = _groups(channels, notices)
    if count := count_rotations(channels.said):
        note(notices, "warning", f"{count} rotations of the source file are left out")
    if original.is_turned and TRIAL in groups:
        # They say which way the axes of the laboratory point.
        groups = _select(groups, lambda group, name: not (group == TRIAL and name.endswith("_DIRECTION")))
    if original.factor != 1.0 or original.is_turned:
        groups.pop("SEG", None)
    plates = plates_of(channels)
    reason = _reason_against_samples(channels, original, rate) if len(channels) else ""
    if reason:
        note(notices, "warning", f"{_count(channels, len(plates))} of the source file are left out: {reason}")
    if reason or not len(channels):
        return OriginalData(None, _without(groups, ANALOG, PLATES))
    data = _with_usual_offsets(OriginalData(channels, groups))
    if plates:
        moved = _move_plates(channels, data.groups[PLATES], original)
        reason = _reason_against_plates(channels, moved, original, unit)
        if reason:
            told = (
                "1 force plate of the source file is"
                if len(plates) == 1
                else f"{len(plates)} force plates of the file are"
            )
            note(notices, "warning", f"{told} left out: {reason}")
            data = replace(data, groups=_without(data.groups, PLATES))
        else:
            data = replace(data, groups=data.groups | {PLATES: moved})
    count = len(plates) if PLATES in data.groups else 0
    note(notices, "note", f"{_count(channels, count)} are written from the source file, without later edits")
    return data


def _count(channels: Channels, plates: int) -> str:
    told = f"{len(channels)} analog channels"
    return f"{told} and {plates} force plate{'s' if plates > 1 else ''}" if plates else told


def clear_baseline(data: OriginalData, notices: list[Notice]) -> OriginalData:
    """Return the data without the frames of FORCE_PLATFORM:ZERO, for files whose frames are others."""
    plates = data.groups.get(PLATES, {})
    zero = plates.get("ZERO")
    if zero is None or not all(number > 0 for number in zero.numbers()):
        return data
    what = "FORCE_PLATFORM:ZERO is written as 0: its frames of the source file for a baseline are not the same here"
    note(notices, "note", what)
    cleared = replace(zero, data=bytes(len(zero.data)))
    return replace(data, groups=data.groups | {PLATES: plates | {"ZERO": cleared}})


_MACHINE: Final = Machine(INTEL)


def _groups(channels: Channels, notices: list[Notice]) -> Groups:
    """The parameters of a file that are written again, without those that count or place its frames."""
    groups: Groups = {}
    too_long = []
    for key, parameter in channels.said.parameters.items():
        group, _, name = key.partition(":")
        # A record without a name would end the parameters.
        if not name or group in _OF_OTHER_DATA or (group in _OWN and group not in (ANALOG, PLATES, TRIAL)):
            continue
        if (group == ANALOG and name in ("USED", "RATE")) or (group == TRIAL and name.startswith("ACTUAL_")):
            groups.setdefault(group, {})
        elif fits_record(parameter):
            groups.setdefault(group, {})[name] = parameter
        else:
            too_long.append(key)
    if too_long:
        note(notices, "warning", f"parameters of the source file are too long to write: {', '.join(too_long)[:200]}")
    return {name: group for name, group in groups.items() if group or name in _OWN}


def _select(groups: Groups, is_kept: Callable[[str, str], bool]) -> Groups:
    selected = {
        group: {name: part for name, part in parts.items() if is_kept(group, name)} for group, parts in groups.items()
    }
    return {group: parts for group, parts in selected.items() if parts or group in _OWN}


def _without(groups: Groups, *names: str) -> Groups:
    return {name: group for name, group in groups.items() if name not in names}


def _reason_against_samples(channels: Channels, original: Original, rate: float) -> str:
    """Why frames of a clip cannot have the samples of the file, "" where they can."""
    if len(channels) * channels.samples > _MOST_VALUES:
        return f"a frame has more than {_MOST_VALUES} analog values"
    if original.is_resampled:
        return "the frames were resampled"
    own = channels.said.number("POINT:RATE") or channels.said.rate
    if not (math.isfinite(own) and own > 0):
        own = channels.rate / channels.samples
    if math.isfinite(own) and abs(own / rate - 1) >= _SAME_RATE:
        return f"it has {own:g} frames a second, the clip {rate:g}"
    return ""


def _with_usual_offsets(data: OriginalData) -> OriginalData:
    """The data with offsets as words with a sign, which all programs read, where this changes no value.

    Integers without a sign minus their offset are exact in single precision: no offset over 32,767 is needed.
    """
    channels = data.channels
    if channels is None or (channels.unsigned and channels.layout.real and (channels.offsets > _MOST_SIGNED).any()):
        return data
    shifts = np.where(channels.unsigned & (channels.offsets > _MOST_SIGNED), np.floor(channels.offsets), 0.0)
    analog, left = dict(data.groups[ANALOG]) if ANALOG in data.groups else {}, channels.offsets - shifts
    for name, part in analog.items():
        if not _OFFSETS.fullmatch(name) or not (count := len(part.numbers())):
            continue
        offsets = np.concatenate([left[:count], np.zeros(max(0, count - len(left)))])
        is_whole = (offsets == np.rint(offsets)).all() and (np.abs(offsets) <= _MOST_SIGNED).all()
        if channels.unsigned or (is_whole and part.kind == 4):
            kind, form = (2, "<i2") if is_whole else (4, "<f4")
            analog[name] = Parameter(kind, part.dimensions, offsets.astype(form).tobytes(), _MACHINE, part.spelling)
        left = left[count:]
    if channels.unsigned:
        analog["FORMAT"] = Parameter(-1, (6,), b"SIGNED", _MACHINE, "ANALOG:FORMAT")
    return replace(data, groups=data.groups | {ANALOG: analog}, shifts=shifts if shifts.any() else None)


def _move_plates(channels: Channels, plates: Mapping[str, Parameter], original: Original) -> dict[str, Parameter]:
    """The parameters of force plates in the unit and the axes of the clip. Origins are in the axes of their plates."""
    moved = dict(plates)
    if original.factor == 1.0 and not original.is_turned:
        return moved
    axes, signs = [axis for axis, _ in original.axes], [sign for _, sign in original.axes]
    for name, part in plates.items():
        if not _LENGTHS.fullmatch(name):
            continue
        numbers = np.array(part.numbers(signed=True))
        triples = numbers[: len(numbers) // 3 * 3].reshape(-1, 3) * original.factor
        if name.startswith("CORNERS"):
            triples = triples[:, axes] * signs
        numbers[: triples.size] = triples.ravel()
        moved[name] = Parameter(4, part.dimensions, numbers.astype("<f4").tobytes(), _MACHINE, part.spelling)
    return moved


def _reason_against_plates(channels: Channels, moved: Mapping[str, Parameter], original: Original, unit: str) -> str:
    """Why force plates cannot be stated in the unit and the size of the clip, "" where they can."""
    if original.is_resized:
        return "the size of the clip was changed, forces cannot follow"
    if original.factor == 1.0:
        return ""
    units = {"POINT:UNITS": Parameter(-1, (len(unit.encode()),), unit.encode(), _MACHINE)}
    own = {f"{PLATES}:{name}": part for name, part in moved.items()}
    said = replace(channels.said, parameters=channels.said.parameters | own | units)
    before, after = plates_of(channels), plates_of(replace(channels, said=said))
    same = all(np.allclose(one.factors, other.factors) for one, other in zip(before, after, strict=True))
    return "" if same else "the file does not state the units of their moments, which would follow the unit of length"
