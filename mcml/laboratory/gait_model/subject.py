"""A subject and a trial as the gait model needs them: measures, directions of the laboratory, static offsets."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from mcml.laboratory.gait_model.lower_body import (
    Markers,
    hip_in_pelvis,
    pelvis_frame,
    place_in,
    sacrum_of,
)
from mcml.laboratory.gait_model.measures import USUAL_DIAMETER, Measures
from mcml.laboratory.gait_model.segment_frames import column
from mcml.laboratory.gait_model.static_pass import MEDIAL, FootOption, has_knee_axis, stand
from mcml.motion.skeleton import Array

LEAST_TRAVEL: Final = 500.0
"""Millimetres that a pelvis travels at least in a trial over ground."""

_STILL: Final = 100.0
"""Millimetres that ankles move at most in a standing trial."""
_LARGEST_DIAMETER: Final = 40.0
_SAME_DIAMETER: Final = 0.5
"""Millimetres between the diameters that both knees tell, at most."""
_OFFSETS: Final = ("StaticPlantFlex", "StaticRotOff")
_OPTIONS: Final[tuple[FootOption, ...]] = ("as it stands", "foot flat")
_UNUSED: Final = ((), ("KNM",), ("MED",), MEDIAL)
"""Medial markers that a program may leave alone, in the order in which they are tried."""
_JOINTS: Final = {"KNM": "the knees", "MED": "the ankles"}
_SAME_OFFSET: Final = 0.002
_DIGITS: Final = 4
"""Radians to which stored offsets and those of a trial agree: to 0.1 degrees; of equal ones the first counts."""


@dataclass(frozen=True, eq=False)
class Subject:
    """measures: of the file, with those that a standing trial itself tells. diameter: of markers. width, depth:
    millimetres between the front spines, and from their middle to that of the back ones, NaN where unknown. laboratory:
    (3, 3) forward, left, up as columns. is_static: whether the trial is a standing one; then foot: how it takes the
    foot; unused: its medial markers ("KNM", "MED") that tell no axis of a joint; offsets: the angles that it tells.

    travel_note, diameter_note, static_note: assumptions, "" for none.
    """

    measures: Measures
    diameter: float
    width: float
    depth: float
    laboratory: Array
    is_static: bool = False
    foot: FootOption = "as it stands"
    unused: tuple[str, ...] = ()
    offsets: Mapping[str, float] = field(default_factory=dict)
    travel_note: str = ""
    diameter_note: str = ""
    static_note: str = ""

    @property
    def up(self) -> Array:
        """(3,) of the laboratory."""
        axis: Array = self.laboratory[:, 2]
        return axis


def find_subject(measures: Measures, markers: Markers, up: Array, foot: FootOption | None = None) -> Subject:
    """Find the subject of a trial.

    markers: (n, 3) millimetres of the whole recording, or of evenly spaced frames of it with both ends. up: (3,) an
    axis of the laboratory. foot: how a standing trial takes the foot, None to tell it by stored offsets.
    """
    diameter, diameter_note = _find_diameter(measures, markers)
    width = measures.get("InterAsisDistance")
    depth = np.nan
    laboratory, travel_note = np.stack([*_level_axes(up), up], axis=1), "the pelvis is never seen"
    if has_pelvis(markers):
        if width is None:
            width = _middle(np.linalg.norm(markers["LASI"] - markers["RASI"], axis=1))
        depth = _middle(np.linalg.norm((markers["LASI"] + markers["RASI"]) / 2 - sacrum_of(markers), axis=1))
        laboratory, travel_note = find_laboratory(markers, up)
    subject = Subject(
        measures, diameter, np.nan if width is None else width, depth, laboratory, travel_note=travel_note,
        diameter_note=diameter_note,
    )  # fmt: skip
    options = _OPTIONS if foot is None else (foot,)
    return _with_static(subject, markers, options) if has_pelvis(markers) and is_standing(markers) else subject


def has_pelvis(markers: Markers) -> bool:
    """Whether both front spines, and both back ones or the sacrum, have markers."""
    return {"LASI", "RASI"} <= markers.keys() and ({"LPSI", "RPSI"} <= markers.keys() or "SACR" in markers)


def find_laboratory(markers: Markers, up: Array) -> tuple[Array, str]:
    """(axes (3, 3), how they were found): forward along the axis of the laboratory that the pelvis travels along.

    A pelvis that stays, on a belt or in standing, tells by where it faces. Axes are columns: forward, left, up.
    """
    origin, frame = pelvis_frame(markers)
    seen = np.flatnonzero(np.isfinite(frame).all(axis=(1, 2)))
    if not len(seen):
        return np.stack([*_level_axes(up), up], axis=1), "the pelvis is never seen"
    away = origin[seen[-1]] - origin[seen[0]]
    away = away - (away @ up) * up
    note = "forward is the axis of the laboratory along which the pelvis travels"
    if float(np.linalg.norm(away)) < LEAST_TRAVEL:
        away = column(frame, 0)[seen].mean(axis=0)
        away = away - (away @ up) * up
        note = "the pelvis stays: forward is the axis of the laboratory that it faces"
    forward = np.zeros(3)
    axis = int(np.argmax(np.abs(away)))
    forward[axis] = 1.0 if away[axis] > 0 else -1.0
    return np.stack([forward, np.cross(up, forward), up], axis=1), note


def is_standing(markers: Markers) -> bool:
    """Whether both ankles and the pelvis stay: files seldom say whether a trial is a static one."""
    names = [name for name in ("LANK", "RANK", "LASI", "RASI") if name in markers]
    if not {"LANK", "RANK"} & set(names):
        return False
    for name in names:
        seen = markers[name][np.isfinite(markers[name]).all(axis=1)]
        if not len(seen) or float(np.linalg.norm(np.subtract(*np.percentile(seen, [95, 5], axis=0)))) > _STILL:
            return False
    return True


def _with_static(subject: Subject, markers: Markers, options: Sequence[FootOption]) -> Subject:
    """The same with offsets of this standing trial, in the variant that the stored offsets tell."""
    measures = subject.measures
    best, least = None, np.inf
    present = {name for name in MEDIAL if any(f"{side}{name}" in markers for side in "LR")}
    for unused in (each for each in _UNUSED if set(each) <= present):
        own = leave_out(unused, markers)
        sides = [side for side in "LR" if not list_lacks(side, own, measures)]
        for option in options if sides else ():
            offsets = _offsets_of(subject, own, sides, option)
            errors = [abs(value - stored) for name, value in offsets.items()
                      if (stored := measures.get(name)) is not None]  # fmt: skip
            error = round(max(errors, default=0.0), _DIGITS)
            if error < least:
                best, least = (unused, option, offsets), error
    if best is None:
        return subject
    unused, option, offsets = best
    is_told = least < _SAME_OFFSET and any(
        measures.get(f"{side}{name}") is not None for side in "LR" for name in _OFFSETS
    )
    how = "with the heel set to the height of the toe" if option == "foot flat" else "with heel and toe as they stand"
    why = "as the stored offsets tell" if is_told else "which the file does not tell"
    why = why if len(options) > 1 else "as a property states"
    medial = f", without the medial markers of {' and '.join(_JOINTS[name] for name in unused)}" if unused else ""
    note = f"a standing trial: offsets of the feet are its own, {how}{medial}, {why}"
    return replace(
        subject, measures=measures.with_values(offsets), is_static=True, foot=option, unused=unused,
        offsets=offsets, static_note=note,
    )  # fmt: skip


def leave_out(stems: Collection[str], markers: Markers) -> Markers:
    """Markers without those of both sides with these names."""
    return {name: places for name, places in markers.items() if name[1:] not in stems} if stems else markers


def _offsets_of(subject: Subject, markers: Markers, sides: Sequence[str], option: FootOption) -> dict[str, float]:
    """The measures that a standing trial tells, in radians, without unknown ones."""
    measures, diameter = subject.measures, subject.diameter
    origin, pelvis = pelvis_frame(markers)
    offsets: dict[str, float] = {}
    for side in sides:
        hip = place_in(origin, pelvis, hip_in_pelvis(side, measures, subject.width, diameter))
        offsets |= stand(side, hip, markers, measures, diameter, subject.up, option).offsets
    return {name: float(value) for name, value in offsets.items() if np.isfinite(value)}


def list_lacks(side: str, markers: Markers, measures: Measures) -> list[str]:
    """The markers and measures without which a standing trial has no offsets of a side."""
    needed = [name for name in ("ANK", "TOE", "HEE") if f"{side}{name}" not in markers]
    if not has_knee_axis(side, markers):
        needed += [name for name in ("KNE", "THI") if f"{side}{name}" not in markers]
    if f"{side}MED" not in markers and f"{side}TIB" not in markers:
        needed.append("TIB")
    widths = [name for name in ("KneeWidth", "AnkleWidth") if measures.get(f"{side}{name}") is None]
    if all(measures.get(f"{each}LegLength") is None for each in "LR"):
        widths.append("LegLength")
    return [f"marker {side}{name}" for name in needed] + [f"measure {side}{name}" for name in widths]


def _find_diameter(measures: Measures, markers: Markers) -> tuple[float, str]:
    """(millimetres, how it is known): stated, else as far as knee markers are from centres that the file has."""
    stated = measures.get("MarkerDiameter")
    if stated is not None:
        return stated, ""
    told = []
    for side in "LR":
        width = measures.get(f"{side}KneeWidth")
        centre = next((name for name in (f"{side}FEO", f"{side}KJC") if name in markers), None)
        if width is not None and centre is not None and f"{side}KNE" in markers:
            away = np.linalg.norm(markers[f"{side}KNE"] - markers[centre], axis=1)
            away = away[np.isfinite(away)]
            # The model places its centre at one distance from the marker in all frames; other centres are not its own.
            if len(away) and float(np.subtract(*np.percentile(away, [95, 5]))) <= _SAME_DIAMETER:
                told.append(2 * float(np.median(away)) - width)
    is_plausible = all(0 < diameter <= _LARGEST_DIAMETER for diameter in told)
    if told and is_plausible and max(told) - min(told) <= _SAME_DIAMETER:
        diameter = float(np.mean(told))
        return diameter, f"marker diameter not stated; {diameter:.1f} mm by the knee centres of the file"
    return USUAL_DIAMETER, f"marker diameter not stated, {USUAL_DIAMETER:g} mm assumed"


def _middle(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _level_axes(up: Array) -> tuple[Array, Array]:
    """Two axes across `up`, in the order that makes all three right-handed."""
    first = np.roll(np.abs(up), 1)
    return first, np.cross(up, first)
