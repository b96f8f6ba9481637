"""Feet locked in a range of a clip: what is not meant keeps its bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError
from mcml.motion.edits.foot_locking import lock_clip_feet
from mcml.motion.frames import in_columns
from mcml.motion.markers import marker_skeleton
from tests.motion.test_retarget import taken

WALK = "bvh/bandai/dataset-1_walk_normal_001.bvh"


@pytest.mark.parametrize("rows", [slice(0, 195), slice(40, 120)])
def test_only_legs_in_the_range_change(shared: Path, rows: slice) -> None:
    skeleton, block, reading = taken(shared / WALK)
    made = lock_clip_feet(skeleton, block, rows, 1 / 30, ("left",), reading=reading)
    columns = skeleton.columns()
    before, after = (in_columns(each, columns) for each in (block, made.edited.block))
    changed = before != after
    assert changed.any()
    assert not changed[: rows.start].any()
    assert not changed[rows.stop :].any()
    names = {skeleton.names[columns[place][0]] for place in np.flatnonzero(changed.any(axis=0))}
    # The right leg bends too where the body is lowered.
    assert names <= {"Root", "joint_Root"} | {
        f"{side}_{part}" for side in ("left", "right") for part in ("up_leg", "low_leg", "foot")
    }
    # Angles stay near to what they were: nothing rolls over.
    assert np.abs(after - before).max() < 60
    ((leg, foot),) = made.feet
    assert leg.side == "left"
    assert all(rows.start <= first and last < rows.stop for first, last in foot.contacts)
    assert foot.after < 0.2 * foot.before


def test_a_skeleton_without_legs_is_refused(shared: Path) -> None:
    _, block, _ = taken(shared / WALK)
    with pytest.raises(ConversionError, match="no left or right leg"):
        lock_clip_feet(marker_skeleton(("a", "b")), block, slice(0, 9), 1 / 30, ("left", "right"))
