"""Which columns of a TRC belong to which marker: its labels, NumMarkers, axes and first row need not agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcml.errors import FormatError, Notice
from mcml.formats.format import Limits, note
from mcml.formats.text.numbers import is_whole
from mcml.formats.trc.rows import Columns
from mcml.numerics.runs import find_consecutive


def find_columns(
    cells: Sequence[str],
    facts: Mapping[str, str],
    axes: int,
    row: Sequence[bytes],
    limits: Limits,
    notices: list[Notice],
) -> tuple[list[str], Columns]:
    """(labels, their columns). Columns without a label are left out, with a notice that names them.

    cells: the fourth line from its third cell on. axes: number of axes in the fifth line. row: the cells of the first
    one. Raises FormatError if there are more labels than columns.
    """
    labels = [(place, cell) for place, cell in enumerate(cells) if cell]
    said = next((text for name, text in facts.items() if name.lower() == "nummarkers"), "")
    wanted = int(said) if is_whole(said) and int(said) >= 0 else None
    limits.check_points([cell for _, cell in labels])
    width = max(len(row) - 2, 0)
    if wanted != len(labels):
        points = -(-width // 3)
        if points < len(labels) and points != wanted and wanted is not None:
            raise FormatError(
                f"NumMarkers says {wanted}, {len(labels)} labels follow, the first row has {points} points",
                remedy="Write one label for each marker.",
            )
        if not labels and wanted:
            note(notices, "warning", f"NumMarkers says {wanted}, no labels follow: the markers are unnamed")
            limits.check_points([""] * wanted)
            return ["unnamed"] * wanted, _columns(3 * wanted, range(wanted))
        count = f"NumMarkers says {said or 'nothing'}, there are {len(labels)} labels"
        if points == wanted and points < len(labels):
            note(notices, "warning", f"{count} and columns for {points}: the first {points} count")
            labels = labels[:points]
        else:
            note(notices, "warning", f"{count}: these count")
    names = [cell for _, cell in labels]
    width = max(width, axes, 3 * len(names))
    in_threes = all(place % 3 == 0 and place + 3 <= width for place, _ in labels)
    # Labels two columns apart, or between blanks, do not decide the place of their columns.
    places = [place // 3 for place, _ in labels] if width > 3 * len(names) and in_threes else range(len(names))
    columns = _columns(width, places)
    unlabelled = np.setdiff1d(np.arange(2, width + 2), columns.kept)
    if len(unlabelled):
        note(notices, "warning", f"columns without a label were left out: {_ranges(unlabelled + 1)}")
    return names, columns


def _columns(width: int, places: Sequence[int]) -> Columns:
    """Three columns for the marker at each place."""
    kept = 2 + 3 * np.asarray(places, dtype=np.intp)[:, None] + np.arange(3)
    return Columns(width + 2, kept.reshape(-1))


def _ranges(numbers: np.ndarray) -> str:
    """Columns, counted from 1, as 9-11, 15-17."""
    ranges = find_consecutive(numbers).tolist()
    return ", ".join(f"{first}-{last}" if first != last else str(first) for first, last in ranges)
