"""Tables of many retargeted documents."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcml_schemas.retarget import PartError, Retargeted, RetargetedOne
from mcml_service.actions.composing.describe_retargeting import retarget_table


@given(st.lists(st.floats(0, 100), min_size=3, max_size=30))
def test_rows_farthest_above_the_median_come_first(values: list[float]) -> None:
    def item(number: int, value: float) -> RetargetedOne:
        part = PartError(part="hips", joint="Root", mean=value, largest=value, frame=1)
        made = Retargeted(frames=1, scale=1, matches=[], unmatched_source=[], unmatched_target=[], bones=[], feet=[],
                          parts=[part], notices=[])  # fmt: skip
        return RetargetedOne(source=str(number), name="", made=made)

    rows = retarget_table(item(*pair) for pair in enumerate(values)).rows
    middle = np.median(values)
    spread = max(1.4826 * np.median(np.abs(np.array(values) - middle)), 1.0)
    assert [row.deviation for row in rows] == sorted((row.deviation for row in rows), reverse=True)
    for row in rows:
        assert row.deviation == pytest.approx(max((row.hips - middle) / spread, 0), abs=1e-5)
