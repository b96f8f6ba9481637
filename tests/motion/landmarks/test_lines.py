"""Lines between markers: along limbs, each once, of each person alone."""

from __future__ import annotations

import pytest

from mcml.motion.landmarks.lines import marker_lines
from mcml.motion.landmarks.tables import marker_sets
from mcml.motion.markers import marker_skeleton
from tests.motion.landmarks.standing import NAMES, SKELETON


def test_markers_of_a_person_are_connected_along_limbs() -> None:
    lines = {frozenset((NAMES[start], NAMES[end])) for start, end in marker_lines(SKELETON)}
    wanted = [("LASI", "LKNE"), ("LKNE", "LANK"), ("LANK", "LHEE"), ("LASI", "RASI"), ("RSHO", "C7"), ("LFHD", "LBHD")]
    assert {frozenset(line) for line in wanted} <= lines
    assert not any({"LKNE", "RKNE"} == line for line in lines)
    assert len(lines) == len(marker_lines(SKELETON))


def test_two_people_are_not_connected() -> None:
    names = [f"{who}:{name}" for who in ("Anna", "Bea") for name in NAMES]
    whose = {(names[start][0], names[end][0]) for start, end in marker_lines(marker_skeleton(names))}
    assert whose == {("A", "A"), ("B", "B")}


def test_markers_of_nobody_have_no_lines() -> None:
    assert marker_lines(marker_skeleton([f"M{number}" for number in range(40)])) == ()


@pytest.mark.parametrize("name", sorted(marker_sets()))
def test_both_sides_of_every_set_have_the_same_lines(name: str) -> None:
    names = [marker for marker in marker_sets()[name] if marker]
    skeleton = marker_skeleton(names)
    landmarks = {index: marker_sets()[name][key] for index, key in enumerate(names)}
    sides = {"left": set(), "right": set()}
    for start, end in marker_lines(skeleton):
        ends = landmarks[start], landmarks[end]
        for side, other in (("left", "right"), ("right", "left")):
            if any(side in each for each in ends) and not any(other in each for each in ends):
                sides[side].add(frozenset(each.replace(f"{side}_", "") for each in ends))
    assert sides["left"] == sides["right"]
