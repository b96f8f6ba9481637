"""Landmarks are checked by where they stand: exchanged sides are told, lifted knees are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.on_disk import opened_files
from mcml.files.open_clip import open_clip
from mcml.motion.landmarks.places import check_places, fullest_frame
from mcml.motion.landmarks.recognise import MarkerBody, recognise_markers
from mcml.motion.skeleton import Array

PLACES = {
    "LASI": (12, 100, 10), "LPSI": (5, 102, -10), "LTHI": (15, 75, 0), "LKNE": (12, 50, 2), "LTIB": (12, 30, 0),
    "LANK": (11, 10, 0), "LHEE": (9, 5, -6), "LTOE": (10, 4, 14), "LSHO": (18, 145, 0), "LELB": (24, 115, -3),
}  # fmt: skip


def standing() -> tuple[MarkerBody, Array, list[str]]:
    """A person who faces +Z, +Y is up: the left is +X."""
    places = dict(PLACES) | {name.replace("L", "R", 1): (-x, y, z) for name, (x, y, z) in PLACES.items()}
    names = list(places)
    (body,) = recognise_markers(names)
    return body, np.array(list(places.values()), float), names


@pytest.mark.parametrize("turn", [np.eye(3), np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)])
def test_places_that_fit_tell_nothing(turn: Array) -> None:
    """Whichever axis is up."""
    body, places, _ = standing()
    assert check_places(body, places @ turn) == []


def test_a_mirrored_trial_is_told() -> None:
    body, places, _ = standing()
    (told,) = check_places(body, places * [-1, 1, 1])
    assert "contradict left and right of all names" in told


def test_one_exchanged_pair_is_named() -> None:
    body, places, names = standing()
    knees = [names.index("LKNE"), names.index("RKNE")]
    places[knees] = places[knees[::-1]]
    assert check_places(body, places) == ["places contradict left and right of left_knee_lateral"]


def test_a_lifted_knee_is_no_fault() -> None:
    body, places, names = standing()
    leg = [names.index(name) for name in ("LTHI", "LKNE", "LTIB")]
    places[leg] = [(15, 105, 20), (12, 110, 40), (14, 60, 20)]
    assert check_places(body, places) == []


def test_a_marker_in_front_of_the_thigh_is_no_wand() -> None:
    """A marker on the skin in front of the thigh would turn the plane of the knee by 90 degrees."""
    body, places, names = standing()
    places[names.index("LTHI")] = (12, 75, 9)
    (told,) = check_places(body, places)
    assert told.startswith("left_thigh_tracking is not beside its segment: angles of the knee")
    wider = [*names, "L.Knee.Medial"]
    (body,) = recognise_markers(wider)
    assert check_places(body, np.concatenate([places, [(5, 50, 2)]])) == []


def test_what_is_not_seen_is_not_judged() -> None:
    body, places, names = standing()
    places[names.index("LASI")] = np.nan
    assert check_places(body, places) == []
    full = standing()[1]
    assert fullest_frame([body], np.stack([places, full])) == 1


def test_a_mirrored_file_is_told_in_its_receipt(tmp_path: Path) -> None:
    _, places, names = standing()
    for sign, count in ((1, 0), (-1, 1)):
        row = "\t".join(f"{sign * x:g}\t{y:g}\t{z:g}" for x, y, z in places)
        path = tmp_path / f"trial{sign}.trc"
        path.write_text(
            f"PathFileType\t4\t(X/Y/Z)\t{path.name}\n"
            "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
            f"100\t100\t2\t{len(names)}\tmm\t100\t1\t2\nFrame#\tTime\t" + "\t\t\t".join(names) + "\t\t\n\t\t"
            + "\t".join(f"{axis}{number}" for number in range(1, len(names) + 1) for axis in "XYZ")
            + f"\n\n1\t0\t{row}\n2\t0.01\t{row}\n"
        )  # fmt: skip
        with opened_files(path) as files, gathered(files, FileLimits()) as found:
            shared = open_clip(found.clips[0], ImportOptions(), FileLimits()).shared
        assert shared is not None
        told = [notice for notice in shared.report.notices() if notice.kind == "guess"]
        assert len(told) == count
