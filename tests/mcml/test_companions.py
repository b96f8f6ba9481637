"""Files that stand beside a motion find it by their names, or are problems that say what to do."""

from __future__ import annotations

import io

import pytest

from mcml.files.companions import trial_name
from mcml.files.gather_files import gathered
from mcml.files.limits import FileLimits
from mcml.formats.format import SourceFile

TRC = b"PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
FORCES = b"walk\nversion=1\nendheader\ntime\tF1_vx\tF1_vy\tF1_vz\tF1_px\tF1_py\tF1_pz\n"
LOADS = b'<?xml version="1.0"?>\n<OpenSimDocument Version="40000">\n  <ExternalLoads name="loads"/>\n</OpenSimDocument>'


def content_of(name: str) -> bytes:
    return {"trc": TRC, "xml": LOADS}.get(name.rsplit(".", 1)[1], FORCES)


def gather(*names: str) -> tuple[list[list[str]], list[str]]:
    """(names of the files of each clip, problems) of files with these names."""
    files = [SourceFile(name, io.BytesIO(content_of(name))) for name in names]
    with gathered(files, FileLimits()) as found:
        clips = [[file.name for file in clip.files.values()] for clip in found.clips]
        return clips, [f"{name}: {error.what}" for name, error in found.problems]


@pytest.mark.parametrize(
    "names",
    [
        ("walk.trc", "walk.mot"),
        ("walk.trc", "walk_grf.mot"),
        ("walk.trc", "Walk-Forces.sto"),
        ("walk.markers.trc", "walk.forces.mot", "walk.loads.xml"),
        ("MarkerData/walk.trc", "ForceData/walk_forces.mot"),
        ("motion_capture_walk.trc", "grf_walk.mot"),
        ("a.trc", "b.mot"),
    ],
)
def test_one_trial(names: tuple[str, ...]) -> None:
    clips, problems = gather(*names)
    assert not problems
    assert [sorted(clip) for clip in clips] == [sorted(names)]
    assert clips[0][-1] == names[0]


def test_trials_by_name() -> None:
    clips, problems = gather("walk.trc", "run.trc", "run_grf.mot", "walk_grf.mot", "walk_ik.mot", "stand.trc")
    assert sorted(map(sorted, clips)) == [["run.trc", "run_grf.mot"], ["stand.trc"], ["walk.trc", "walk_grf.mot"]]
    assert problems == [
        "walk_ik.mot: the file holds forces of the ground, and none of the 3 TRC alone has its name",
    ]


def test_equal_names_by_folder() -> None:
    clips, problems = gather("a/1.trc", "b/1.trc", "a/1.mot", "b/1.mot")
    assert not problems
    assert clips == [["a/1.mot", "a/1.trc"], ["b/1.mot", "b/1.trc"]]


def test_two_tables_of_one_trial() -> None:
    _, problems = gather("walk.trc", "walk.mot", "walk_grf.mot")
    assert len(problems) == 1
    assert "walk.mot already belongs to walk.trc" in problems[0]


def test_forces_alone() -> None:
    clips, problems = gather("walk.mot", "walk.xml")
    assert not clips
    assert problems == [
        "walk.mot: the file holds forces of the ground, and no TRC was sent with it",
        "walk.xml: the file holds external loads of OpenSim, and no TRC was sent with it",
    ]


def test_words_for_the_kind_of_a_file_do_not_count() -> None:
    assert trial_name("P1/Walk 03_grf.mot") == trial_name("walk-03.trc") == ("walk", "03")
    assert trial_name("walk_03.trc") != trial_name("walk_3.trc")
