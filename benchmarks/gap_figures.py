"""Errors of filled gaps by method, on real markers: the table of docs/api/frames-and-labels.md.

`python -m benchmarks.gap_figures` takes the C3D files of the shared data, removes stretches of markers that are known,
and compares the positions that `fill_gaps` puts there with the measured ones.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import numpy as np

import mcml
from mcml.motion.clip import FrameBlock
from mcml.motion.edits.gap_filling import fill_gaps
from mcml.motion.frames import in_columns, joined, remade
from mcml.motion.hub_writer import Flags
from mcml.motion.skeleton import Array, Convention, Skeleton
from mcml.numerics.runs import find_true
from tests.conftest import shared_folder

SECONDS = (0.05, 0.2, 0.5)
UNITS = {"mm": 1.0, "m": 1000.0}
GAPS = 60
"""Of each length in each file."""


def main() -> None:
    """Print the median and the 90th percentile of the largest error of a gap, mm."""
    folder = shared_folder()
    files = sorted((folder / "c3d" / "body").glob("*.c3d")) if folder else []
    print("| gap | spline everywhere | as `fill` does | by a spline | by three markers | by one marker | left |")
    print("|---|---|---|---|---|---|---|")
    for seconds in SECONDS:
        errors: dict[str, list[float]] = defaultdict(list)
        for file in files:
            measure(file, seconds, errors)
        cells = [_cell(errors[name]) for name in ("all-spline", "all", "spline", "segment", "nearby marker")]
        print(f"| {seconds:g} s | {' | '.join(cells)} | {len(errors['left'])} |")


def measure(file: Path, seconds: float, errors: dict[str, list[float]]) -> None:
    """Add the errors of gaps in one file, mm."""
    clip = mcml.read(file)._clip
    skeleton, block = clip.head.skeleton, joined(clip.blocks())
    frame_time = clip.head.seconds_per_frame()
    assert frame_time is not None
    places = _places(skeleton)
    values = in_columns(block, skeleton.columns())
    markers = list(places)
    frames, unit = max(1, round(seconds / frame_time)), UNITS[clip.head.fields["calibration_unit"]]
    chance = np.random.default_rng(7)
    for _ in range(GAPS):
        joint = markers[chance.integers(len(markers))]
        known: Flags = np.all(np.isfinite(values[:, places[joint]]), axis=1)
        runs = [(first, end) for first, end in find_true(known).tolist() if end - first > 3 * frames + 8]
        if not runs:
            continue
        first, end = runs[chance.integers(len(runs))]
        start = int(chance.integers(first + frames, end - 2 * frames))
        truth = values[start : start + frames, places[joint]]
        with_gap = values.copy()
        with_gap[start : start + frames, places[joint]] = np.nan
        gap = remade(block, skeleton.columns(), with_gap, np.arange(len(block), dtype=np.intp), block.ids)
        for name, short in (("all-spline", frames), ("all", round(0.1 / frame_time))):
            error, method = _error(skeleton, gap, places[joint], joint, slice(start, start + frames), short, truth)
            errors["left" if method is None else name].append(error * unit)
            if name == "all" and method is not None:
                errors[method].append(error * unit)


def _error(
    skeleton: Skeleton, block: FrameBlock, axes: list[int], joint: int, rows: slice, short: int, truth: Array
) -> tuple[float, str | None]:
    filled = fill_gaps(skeleton, block, rows, short, 10**6, [joint])
    made = in_columns(filled.block, skeleton.columns())[rows, axes]
    methods = [method for method, count in filled.counts.items() if count]
    return float(np.linalg.norm(made - truth, axis=1).max()), methods[0] if methods else None


def _places(skeleton: Skeleton) -> dict[int, list[int]]:
    """Columns of X, Y, Z of each marker."""
    columns = list(skeleton.columns())
    return {
        joint: [columns.index((joint, channel)) for channel in range(3)]
        for joint, each in enumerate(skeleton.joints)
        if each.convention is Convention.MARKER
    }


def _cell(errors: list[float]) -> str:
    if not errors:
        return "–"
    median, most = np.percentile(errors, [50, 90])
    return f"{median:.1f}, {most:.1f} ({len(errors)})"


if __name__ == "__main__":
    main()
