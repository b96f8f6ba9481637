"""`mcml import`: many files, a call for each group of them."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest
from rich.console import Console

from mcml.client import folders
from mcml.client.client import Client
from mcml.client.folders import _upload, groups_of
from mcml.client.pace import Pace
from mcml.errors import UnsupportedError
from mcml_service.cli.terminal import bar as bars
from tests.builders import ASF, amc, bvh, read_by
from tests.cli.test_access import library as server  # noqa: F401
from tests.cli.test_cli import Mcml, environment, mcml  # noqa: F401
from tests.force_trials import make_trial


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Ten clips, one of them cut off, and two folders whose skeletons have one name."""
    made = tmp_path / "takes"
    for part in ("a", "b"):
        (made / part).mkdir(parents=True)
        (made / part / "leg.asf").write_bytes(ASF)
        (made / part / "leg.amc").write_bytes(amc(4 if part == "a" else 5))
    for number in range(10):
        (made / f"{number}.bvh").write_bytes(bvh(3, seed=number))
    (made / "4.bvh").write_bytes(bvh(3)[:-40])
    (made / "notes.txt").write_text("no motion")
    return made


def names(groups: list[list[Path]]) -> list[list[str]]:
    return [[path.name for path in group] for group in groups]


def test_groups_hold_every_file_once_and_what_belongs_together(folder: Path) -> None:
    (folder / "more.zip").write_bytes(b"PK\x03\x04")
    loose = folder / "a" / "leg.amc"
    groups = list(groups_of([folder, loose], 4))
    assert names(groups) == [
        ["leg.amc", "leg.asf"],
        ["leg.amc", "leg.asf"],
        ["0.bvh", "1.bvh", "2.bvh", "3.bvh"],
        ["4.bvh", "5.bvh", "6.bvh", "7.bvh"],
        ["more.zip"],
        ["8.bvh", "9.bvh"],
        ["leg.amc"],
    ]
    assert [group[0].parent.name for group in groups[:2]] == ["a", "b"]
    assert Counter(map(len, groups_of([folder], 1))) == {1: 11, 2: 2}


def test_a_gltf_comes_with_its_buffers(tmp_path: Path) -> None:
    (tmp_path / "scene.gltf").write_text('{"buffers": [{"uri": "parts/a%201.bin"}, {"uri": "../b.bin"}]}')
    (tmp_path / "parts").mkdir()
    for path in ("parts/a 1.bin", "parts/c.bin", "../b.bin"):
        (tmp_path / path).write_bytes(b"1")
    assert names(list(groups_of([tmp_path], 4))) == [["a 1.bin", "scene.gltf"]]


def test_a_trc_comes_with_the_forces_of_its_trial(tmp_path: Path) -> None:
    table = "endheader\ntime\tground_force_vx\tground_force_vy\tground_force_vz\tground_force_px\tground_force_py"
    for path in ("trc/walk.trc", "trc/run.trc", "mot/walk_forces.mot", "trc/run_grf.mot", "mot/run_grf.mot"):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(f"{table}\tground_force_pz\n")
    (tmp_path / "mot" / "jump_grf.sto").write_text(f"{table}\tground_force_pz\n")
    (tmp_path / "trc" / "walk_ik.mot").write_text("endheader\ntime\tpelvis_tilt\n")
    (tmp_path / "trc" / "run_grf.xml").write_text("<OpenSimDocument><ExternalLoads/></OpenSimDocument>")
    assert names(list(groups_of([tmp_path], 4))) == [
        ["run_grf.mot", "run_grf.xml", "run.trc"],
        ["walk_forces.mot", "walk.trc"],
        ["jump_grf.sto", "run_grf.mot"],
    ]


def test_groups_are_bounded_in_bytes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    size = (folder / "0.bvh").stat().st_size
    monkeypatch.setattr(folders, "MOST_BYTES", int(2.5 * size))
    with (folder / "5.bvh").open("ab") as large:
        large.truncate(9 * size)
    groups = names(list(groups_of([folder], 64))[2:])
    assert ["5.bvh"] in groups
    assert max(map(len, groups)) == 2
    assert sorted(name for group in groups for name in group) == [f"{number}.bvh" for number in range(10)]


def test_nothing_is_imported_where_a_path_is_wrong(folder: Path) -> None:
    with pytest.raises(UnsupportedError):
        list(groups_of([folder, folder / "nothing"], 64))


@pytest.mark.parametrize("processes", [1, 2])
def test_a_folder_is_imported_in_few_calls(
    mcml: Mcml,  # noqa: F811
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    processes: int,
) -> None:
    read_by(monkeypatch, processes)
    calls = []

    def counted(client: Client, paths: list[Path], *rest: object) -> object:
        calls.append(len(paths))
        return _upload(client, paths, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(folders, "_upload", counted)
    code, output, _ = mcml("import", str(folder))
    assert (code, calls) == (3, [2, 2, 10])
    assert "11 stored, 1 failed" in output
    assert [line.split()[1] for line in output.splitlines() if line.startswith("stored")] == [
        *("leg", "leg"),
        *(str(number) for number in range(10) if number != 4),
    ]
    assert "failed   4.bvh:" in output
    (folder / "4.bvh").write_bytes(bvh(3, seed=4))
    code, output, _ = mcml("import", str(folder), "--json")
    answer = json.loads(output)
    assert (code, answer["problems"]) == (0, [])
    assert [item["name"] for item in answer["documents"] if not item["skipped"]] == ["4"]


def test_all_bad_is_failed(mcml: Mcml, folder: Path) -> None:  # noqa: F811
    (folder / "5.bvh").write_bytes(b"HIERARCHY")
    assert mcml("import", str(folder / "4.bvh"), str(folder / "5.bvh"))[0] == 1


def _drawn(bar: bars.Bar) -> str:
    with (shown := Console(width=100)).capture() as drawn:
        shown.print(bar._bar.get_renderable())
    return drawn.get()


def test_the_bar_counts_files_and_tells_the_rate_and_what_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(bars, "SECONDS_DRAWN", -1)
    monkeypatch.setattr(bars, "Pace", lambda things: Pace(things, lambda: now))
    with bars.Bar("importing", disable=False) as bar:
        task = bar._bar.tasks[0]
        bar.tell(2, 5, "2.bvh")
        assert (task.completed, task.total, task.description, task.fields["pace"]) == (2, 5, "2.bvh", "")
        now = 4.0
        bar.tell(4, 5, "4.bvh")
        assert task.fields["pace"] == "0.5 files/s, 0:02 left"
        assert task.fields["pace"] in _drawn(bar)


def test_several_files_are_one_request(server: Client, folder: Path) -> None:  # noqa: F811
    paths = [folder / f"{number}.bvh" for number in range(3, 6)]
    answer = _upload(server, paths, {}, lambda *_: None)
    assert [item.name for item in answer.documents] == ["3", "5"]
    assert [item.file for item in answer.problems] == ["4.bvh"]


def test_what_is_stored_is_derived_afterwards(mcml: Mcml, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    code, output, _ = mcml("import", "walk.bvh", MCML_DERIVE="yes")
    assert code == 0
    assert "body     walk: unit unknown, up Y (guessed), floor unknown, leg unknown" in output
    assert "1 of 1 documents have theirs" in mcml("doctor")[1]
    code, output, _ = mcml("import", "takes", MCML_DERIVE="yes")
    assert code == 3, "one is cut off"
    assert "up       11 guessed" in output
    assert json.loads(mcml("db", "derive", "--json")[1]) == {"derived": 0, "failed": 0, "columns": 0, "groups": 0}
    mcml("import", "two.htr", "--no-derive", MCML_DERIVE="yes")
    assert "12 of 13 documents have theirs" in mcml("doctor")[1]

    def stopped(*_: object) -> int:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("mcml_service.cli.deriving.derive_missing", stopped)
        code, output, _ = mcml("import", "hand.mcml", MCML_DERIVE="yes")
    assert code == 130
    assert ("1 stored, 0 failed" in output, "mcml db derive goes on" in output) == (True, True)
    assert json.loads(mcml("import", "two.htr", "hand.mcml", "--json", MCML_DERIVE="yes")[1])["documents"][0]["skipped"]
    assert json.loads(mcml("db", "derive", "--json")[1]) == {"derived": 0, "failed": 0, "columns": 0, "groups": 0}, (
        "those were, that were skipped"
    )


def test_a_new_file_replaces_the_frames_of_a_document(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    old, new = tmp_path / "a.bvh", tmp_path / "b.bvh"
    old.write_bytes(bvh(20))
    new.write_bytes(bvh(25))
    uuid = json.loads(mcml("import", str(old), "--json", "--no-derive")[1])["documents"][0]["id"]
    assert "unchanged" in "".join(mcml("import", str(old), "--as", uuid)[1:])
    told = "".join(mcml("import", str(new), "--as", uuid)[1:])
    assert "revision 2: frames" in told
    assert "25 in all" in told
    assert json.loads(mcml("import", str(old), "--as", uuid, "--json")[1])["frames"] == 20


def test_a_trial_in_two_files_tells_its_markers(mcml: Mcml, tmp_path: Path) -> None:  # noqa: F811
    files = make_trial(1).write(tmp_path)
    code, output, _ = mcml("import", *map(str, files))
    assert code == 0
    assert "1 stored, 0 failed" in output
    assert "12 frames, 100 Hz, mm, 0 of 1 markers on known landmarks" in output
    assert "Fx1" in mcml("measurements", "walk")[1]
