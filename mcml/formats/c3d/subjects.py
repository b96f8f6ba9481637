"""The subject of a C3D file: its measures, and its markers in frames of the whole recording."""

from __future__ import annotations

import re
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mcml.formats.c3d.analog import Channels
from mcml.formats.c3d.layout import scales_said
from mcml.formats.c3d.parameters import Statements
from mcml.formats.c3d.points import Points
from mcml.formats.c3d.quantities import decode_text, texts_of
from mcml.motion.skeleton import Array

_OTHER_GROUPS: Final = frozenset(
    {"POINT", "ANALOG", "FORCE_PLATFORM", "EVENT", "EVENT_CONTEXT", "TRIAL", "ANALYSIS", "ROTATION", "DATA_BLOCKS",
     "SEG", "MANUFACTURER", "SUBJECTS"}
)  # fmt: skip
_PROCESSING: Final = "PROCESSING"
_MOST_POSITIONS: Final = 1_000_000
_MARKS: Final = re.compile(r"[\W_]+")


def read_measures(said: Statements, prefix: str = "") -> dict[str, float]:
    """Numbers that may be measures of a subject, by name: of the group PROCESSING, or of one named after the subject.

    prefix: of its markers. Names may begin with the name of the subject.
    """
    subjects = subjects_of(said) + ([prefix.strip()] if prefix.strip() else [])
    names = {_bare(name) for name in subjects} - {""}
    groups = _numbers_by_group(said)
    own = [group for group in groups if group != _PROCESSING and _bare(group) in names]
    others = [group for group in groups if group != _PROCESSING and group not in own]
    measures: dict[str, float] = {}
    for group in (*own, _PROCESSING, *others):
        for name, value in groups.get(group, {}).items():
            measures.setdefault(_without_subject(name, subjects), value)
    return measures


def read_measures_by_subject(said: Statements) -> dict[str, dict[str, float]]:
    """Numbers that may be measures, by subject and name; "" is the only subject of a file.

    Of several subjects, those in a group named after the subject, or with names that begin with the subject's name.
    """
    subjects = subjects_of(said)
    if len(subjects) < 2:
        return {"": read_measures(said)}
    # "Anna" must not take the measures of "Annabel".
    longest_first = sorted(subjects, key=len, reverse=True)
    of_group = {_bare(subject): subject for subject in subjects}
    measures: dict[str, dict[str, float]] = {subject: {} for subject in subjects}
    for group, numbers in _numbers_by_group(said).items():
        for name, value in numbers.items():
            subject = of_group.get(_bare(group))
            if subject is None:
                subject = next((each for each in longest_first if name.lower().startswith(each.lower())), None)
            if subject is not None:
                measures[subject].setdefault(_without_subject(name, [subject]), value)
    return measures


def read_measures_of(said: Statements, prefix: str) -> dict[str, float]:
    """Numbers that may be measures of one of several subjects, by name: none of a subject that the file does not name.

    prefix: of its markers.
    """
    by_subject = read_measures_by_subject(said)
    return next((own for subject, own in by_subject.items() if subject and _bare(subject) == _bare(prefix)), {})


def subjects_of(said: Statements) -> list[str]:
    """The names of the subjects of a file, each once."""
    names = (decode_text(text) for text in said.texts("SUBJECTS:NAMES"))
    return list(dict.fromkeys(name for name in names if name))


def _numbers_by_group(said: Statements) -> dict[str, dict[str, float]]:
    """The first number of each parameter that may be a measure, by group and name."""
    groups: dict[str, dict[str, float]] = {}
    for key, parameter in said.parameters.items():
        group, _, name = key.partition(":")
        numbers = parameter.numbers(signed=True)[:1]
        if group not in _OTHER_GROUPS and numbers and np.isfinite(numbers[0]):
            groups.setdefault(group, {})[parameter.spelling.partition(":")[2] or name] = numbers[0]
    return groups


def read_sample(channels: Channels) -> tuple[list[str], NDArray[np.intp], Array]:
    """(labels of all points, frames (n,) from 0, positions (n, points, 3) in the unit of the file, NaN where missing).

    All frames of a trial of usual length; of long ones evenly spaced frames, with the first and the last one.
    """
    layout, said = channels.layout, channels.said
    labels = [decode_text(text) for text in texts_of(said, "POINT:LABELS")][: layout.points]
    labels += ["unnamed"] * (layout.points - len(labels))
    count = max(2, _MOST_POSITIONS // max(1, layout.points))
    wanted = np.unique(np.linspace(0, layout.frames - 1, min(count, layout.frames)).astype(np.intp))
    points = Points(channels.stream, layout, said.machine, abs(scales_said(said)[0][0]))
    positions, residuals = [np.empty((0, layout.points, 3))], [np.empty((0, layout.points))]
    for first in range(0, layout.frames, points.block):
        rows = wanted[(wanted >= first) & (wanted < first + points.block)] - first
        coordinates, own = points.read(first, points.block)
        rows = rows[rows < len(coordinates)]
        positions.append(coordinates[rows])
        residuals.append(own[rows])
    places, missing = np.concatenate(positions), np.concatenate(residuals) < 0
    # Files whose residuals are all negative state no residuals; their coordinates count.
    if not missing.all():
        places[missing] = np.nan
    return labels, wanted[: len(places)], places


def _bare(name: str) -> str:
    return _MARKS.sub("", name).lower()


def _without_subject(name: str, subjects: list[str]) -> str:
    for subject in subjects:
        if name.lower().startswith(subject.lower()):
            return name[len(subject) :].lstrip(":_ ")
    return name
