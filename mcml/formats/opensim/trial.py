"""A trial of a laboratory for OpenSim: markers as TRC, force plates as MOT, and the external loads on the feet as XML.

Source: OpenSim documentation, "Preparing Your Data" and "External Loads": x is forwards, y up, z to the right of a
model; forces in newtons, points in metres, torques in newton metres about the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import PurePath
from typing import Final

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from mcml.errors import ConversionError, DocumentError, Notice
from mcml.formats.format import FileKind, need_seconds, note
from mcml.formats.measurements import Measurements
from mcml.formats.text.number_text import SHORTEST, rows_of_text
from mcml.formats.trc.writer import time_of_first_frame, write_trc
from mcml.laboratory.force_plates import LEAST_FORCE, PlateForces
from mcml.laboratory.gait_events import Side, WalkerPaths, find_facing
from mcml.laboratory.measure_gait import find_walker
from mcml.laboratory.plate_feet import find_loads
from mcml.motion.bodies.clip_body import body_of
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import turn_axis, turn_up
from mcml.motion.skeleton import Array, Convention

_TRAVEL: Final = 0.5
"""Metres that a pelvis travels in a walk over the ground; on a belt, the direction that it faces counts."""
_BODIES: Final = {"left": "calcn_l", "right": "calcn_r"}
"""Bodies of OpenSim's models that the ground loads."""
_TURNS: Final = {(0, 1): (), (2, 1): (("Z", "X"),), (2, -1): (("X", "Z"),), (0, -1): (("X", "Z"), ("X", "Z"))}
"""Quarter turns about Y by (axis, sign) of the direction of a walk, which becomes X."""
_FRAMES_TOGETHER: Final = 1024


class OpenSimTrial:
    """The format `opensim`; see `mcml.formats.format.Writer`."""

    name = "opensim"
    title = "OpenSim trial: markers, forces and external loads"
    label = "OpenSim trial"
    parts = (
        FileKind("opensim-markers", (".markers.trc",), "Markers"),
        FileKind("opensim-forces", (".forces.mot",), "Forces"),
        FileKind("opensim-loads", (".loads.xml",), "External loads"),
    )
    convention = Convention.MARKER
    media_type = "text/plain"
    bodies, markers = False, True
    needs = frozenset({"frame_time", "unit", "force_plates"})
    assumes = ""

    def write(self, clip: ClipStream, part: str) -> Iterator[bytes]:
        need_seconds(clip.head, self.title)
        trial = _prepare(clip)
        if part == "opensim-markers":
            return write_trc(trial.clip)
        if part == "opensim-forces":
            return _write_forces(trial)
        return iter([_write_loads(trial)])


@dataclass(frozen=True)
class _Column:
    """Nine columns of the table: the forces on a plate under one foot. side: of the foot, None for no clear one."""

    plate: int
    side: Side | None


@dataclass(frozen=True, eq=False)
class _Trial:
    """clip: with y up and x forwards. first: number of its first frame in the file. loaded: the frames whose forces are
    known, from 0. columns: in order. owners: by plate, (n,) which of its columns each frame belongs to. turn: (3, 3)
    from the axes of the file to those of the clip.
    """

    clip: ClipStream
    measurements: Measurements
    first: int
    loaded: range
    columns: tuple[_Column, ...]
    owners: dict[int, Array]
    turn: Array


def _prepare(clip: ClipStream) -> _Trial:
    """Turn a trial and find the feet on its plates.

    Raises ConversionError for clips without force plates, or whose frames are not those of the file, one by one.
    """
    ids = _numbers(clip)
    original = clip.original
    assert original is not None
    clip = _face_forward(_stand_up(clip), clip.notices)
    measurements = Measurements(clip.head, original.read_channels)
    plates = measurements.plates_at(ids)
    if not plates:
        raise ConversionError(
            "the file of this document has no force plates that can be used", remedy="Export the markers alone as TRC."
        )
    known: NDArray[np.bool_] = np.all([np.isfinite(forces.force).all(axis=1) for forces in plates.values()], axis=0)
    places = np.flatnonzero(known)
    if not len(places) or not known[places[0] : places[-1] + 1].all():
        raise ConversionError(
            "the forces of some frames are unknown: they are of another frame rate, or beyond the end of the file",
            remedy="Export other frames, or the markers alone as TRC.",
        )
    if not known.all():
        what = f"forces are unknown in {int((~known).sum())} frames at the ends"
        note(clip.notices, "warning", f"{what}: their rows are left out")
    turned = clip.original
    assert turned is not None
    turn = np.zeros((3, 3))
    for axis, (source, sign) in enumerate(turned.axes):
        turn[axis, source] = sign
    in_clip = [_turn_forces(forces, turn) for forces in plates.values()]
    columns, owners = _assign(list(plates), in_clip, _find_walker(clip), len(ids), clip.notices)
    span = range(int(places[0]), int(places[-1]) + 1)
    return _Trial(clip, measurements, int(ids[0]), span, columns, owners, turn)


def _numbers(clip: ClipStream) -> NDArray[np.int64]:
    """(n,) numbers that the frames have in the file."""
    original = clip.original
    if original is None:
        raise ConversionError(
            "forces are those of a C3D file, or of a table beside a TRC; this document has none, or they are not kept",
            remedy="Export the markers alone as TRC.",
        )
    if original.is_resampled or original.is_resized:
        raise ConversionError(
            "forces are those of the captured frames and of the captured size",
            remedy="Leave out the frame rate and the scale.",
        )
    numbers = [np.asarray(block.ids) for block in clip.blocks() if len(block)]
    if not numbers:
        raise ConversionError("the clip has no frames", remedy="Choose other frames.")
    ids = np.concatenate(numbers)
    if ids.dtype.kind != "i" or not (np.diff(ids) == 1).all():
        raise ConversionError(
            "forces are known of captured frames alone, and here some are missing, made or in another order",
            remedy="Choose a range of frames without edits: first and last.",
        )
    return ids.astype(np.int64)


def _stand_up(clip: ClipStream) -> ClipStream:
    """The clip with Y up."""
    calibration = body_of(clip.head, clip.blocks()).calibration
    up = calibration.up
    if up.startswith("-"):
        raise ConversionError(f"{up} is up in this document", remedy="State another up axis: mcml set ID --up Z.")
    if calibration.origins["up"].kind == "guessed":
        note(clip.notices, "guess", f"{up} is up: {calibration.origins['up'].reason}")
    return turn_up(clip, up, "Y")


def _face_forward(clip: ClipStream, notices: list[Notice]) -> ClipStream:
    """The clip with the walk along X, as near as quarter turns can."""
    walker = _find_walker(clip)
    if walker is None:
        note(notices, "note", "the direction of the walk is unknown: axes are only turned until Y is up")
        return clip
    seen = walker.pelvis[np.isfinite(walker.pelvis).all(axis=1)]
    travel = seen[-1] - seen[0] if len(seen) else np.zeros(3)
    if np.hypot(travel[0], travel[2]) < _TRAVEL:
        facing = find_facing(walker)
        travel = facing[np.isfinite(facing).all(axis=1)].sum(axis=0)
    axis = 0 if abs(travel[0]) >= abs(travel[2]) else 2
    for start, end in _TURNS[axis, 1 if travel[axis] >= 0 else -1]:
        clip = turn_axis(clip, start, end)
    return clip


def _find_walker(clip: ClipStream) -> WalkerPaths | None:
    """Feet and pelvis in metres, None where they are unknown."""
    body = body_of(clip.head, clip.blocks())
    try:
        return find_walker(clip.head.skeleton, body.stretch)
    except DocumentError:
        return None


def _turn_forces(forces: PlateForces, turn: Array) -> PlateForces:
    return replace(
        forces,
        force=forces.force @ turn.T,
        centre_of_pressure=forces.centre_of_pressure @ turn.T,
        vertical=turn @ forces.vertical,
    )


def _assign(
    numbers: Sequence[int],
    plates: Sequence[PlateForces],
    walker: WalkerPaths | None,
    frames: int,
    notices: list[Notice],
) -> tuple[tuple[_Column, ...], dict[int, Array]]:
    """Columns of the table, and for each plate which of them each frame belongs to.

    A plate on which both feet stand in turn has a column for each. Between loads the nearest load counts.
    """
    loads = () if walker is None else find_loads(plates, walker)
    columns: list[_Column] = []
    owners: dict[int, Array] = {}
    for place, number in enumerate(numbers):
        own = [load for load in loads if load.plate == place]
        sides = list(dict.fromkeys(load.side for load in own)) or [None]
        unclear = sum(load.side is None for load in own)
        if unclear:
            note(notices, "warning", f"{unclear} loads of plate {number} are of no clear foot: no body has them")
        owner = np.full(frames, len(columns))
        bounds = [0, *((load.end + following.first + 1) // 2 for load, following in pairwise(own)), frames]
        for load, (first, end) in zip(own, pairwise(bounds), strict=bool(own)):
            owner[first:end] = len(columns) + sides.index(load.side)
        owners[number] = owner
        columns += [_Column(number, side) for side in sides]
    return tuple(columns), owners


def _write_forces(trial: _Trial) -> Iterator[bytes]:
    seconds, start = need_seconds(trial.clip.head, "MOT"), time_of_first_frame(trial.clip)
    samples = trial.measurements.samples
    titles = ["time"]
    for number in range(1, len(trial.columns) + 1):
        for quantity in ("force_{}_v", "force_{}_p", "moment_{}_m"):
            titles += [f"ground_{quantity.format(number)}{axis}" for axis in "xyz"]
    lines = [
        f"{_stem(trial.clip)}.forces",
        "version=1",
        f"nRows={len(trial.loaded) * samples}",
        f"nColumns={len(titles)}",
        "inDegrees=yes",
        "endheader",
        "\t".join(titles),
    ]
    yield ("\n".join(lines) + "\n").encode("utf-8", "replace")
    for first in trial.loaded[::_FRAMES_TOGETHER]:
        count = min(_FRAMES_TOGETHER, trial.loaded.stop - first)
        at = start + np.arange(first * samples, (first + count) * samples) / samples * seconds
        yield b"\n".join([*rows_of_text(np.column_stack([at, _table(trial, first, count)]), SHORTEST, "\t"), b""])


def _table(trial: _Trial, first: int, count: int) -> Array:
    """(samples, 9 columns of each) of some frames: force, point and torque, all 0 below 20 N."""
    samples = trial.measurements.samples
    table = np.zeros((count * samples, len(trial.columns), 9))
    for number, owner in trial.owners.items():
        forces = _turn_forces(trial.measurements.sample_plate(number, trial.first + first, count), trial.turn)
        loaded = forces.force @ forces.vertical >= LEAST_FORCE
        torque = forces.free_moment[:, None] * forces.vertical
        values = np.concatenate([forces.force, forces.centre_of_pressure, torque], axis=1)
        rows = np.flatnonzero(loaded & np.isfinite(values).all(axis=1))
        table[rows, np.repeat(owner[first : first + count], samples)[rows]] = values[rows]
    return table.reshape(len(table), -1)


def _write_loads(trial: _Trial) -> bytes:
    root = etree.Element("OpenSimDocument", Version="40000")
    loads = etree.SubElement(root, "ExternalLoads", name="external_loads")
    objects = etree.SubElement(loads, "objects")
    for number, column in enumerate(trial.columns, 1):
        if column.side is None:
            continue
        force = etree.SubElement(objects, "ExternalForce", name=f"{column.side}_foot_plate_{column.plate}")
        for name, text in (
            ("appliesForce", "true"),
            ("applied_to_body", _BODIES[column.side]),
            ("force_expressed_in_body", "ground"),
            ("point_expressed_in_body", "ground"),
            ("force_identifier", f"ground_force_{number}_v"),
            ("point_identifier", f"ground_force_{number}_p"),
            ("torque_identifier", f"ground_moment_{number}_m"),
        ):
            etree.SubElement(force, name).text = text
    etree.SubElement(loads, "groups")
    etree.SubElement(loads, "datafile").text = f"{_stem(trial.clip)}.forces.mot"
    content: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return content


def _stem(clip: ClipStream) -> str:
    return PurePath(clip.head.fields.get("filename", "").replace("\\", "/")).stem or "trial"
