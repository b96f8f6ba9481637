"""Receipts of imports: a unit that makes a giant or a dwarf of a person is reported."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcml.files.gather_files import gathered
from mcml.files.import_options import ImportOptions
from mcml.files.limits import FileLimits
from mcml.files.on_disk import opened_files
from mcml.files.open_clip import open_clip
from mcml_service.actions.importing.load_demo import demo_files
from tests.builders import bvh


def warnings_of(path: Path, unit: str | None) -> list[str]:
    options = ImportOptions(unit=unit)
    with opened_files(path) as files, gathered(files, FileLimits()) as found:
        opened = open_clip(found.clips[0], options, FileLimits())
        receipt = opened.receipt(opened.stream.head, 1)
    return [notice["what"] for notice in receipt["notices"] if notice["kind"] == "warning"]


@pytest.mark.parametrize(
    ("unit", "size"), [("cm", None), ("inch", None), (None, None), ("mm", "0.19 m"), ("m", "190 m")]
)
def test_a_person_of_another_size_is_reported(tmp_path: Path, unit: str | None, size: str | None) -> None:
    (tmp_path / "walk.bvh").write_bytes(demo_files()["walk.bvh"])
    told = [what for what in warnings_of(tmp_path / "walk.bvh", unit) if "this person measures" in what]
    assert [size in what and f"in {unit}," in what for what in told if size] == ([True] if size else [])


def test_what_is_no_person_may_have_any_size(tmp_path: Path) -> None:
    (tmp_path / "crane.bvh").write_bytes(bvh(names=("Base", "Arm", "Hook")))
    assert not [what for what in warnings_of(tmp_path / "crane.bvh", "m") if "measures" in what]
