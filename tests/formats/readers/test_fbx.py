"""FBX files: made as text, and damaged, by the program that evaluates them."""

from __future__ import annotations

import numpy as np
import pytest

from mcml.errors import FormatError, LimitError, NotFoundError
from mcml.formats import READERS, find_format
from mcml.formats.format import Limits, ReadOptions, TakesReader
from mcml.testing import frames
from tests.builders import source
from tests.formats.readers.fbx_text import fbx_text
from tests.formats.readers.posing import places_of, read_clip, reads_or_refuses, spoil

FBX = READERS["fbx"]


def test_bones_stand_where_the_curves_put_them() -> None:
    clip = read_clip("fbx", fbx_text())
    angle = np.radians(9 * np.arange(11))
    hips = np.column_stack([np.arange(11.0), np.full(11, 100.0), np.zeros(11)])
    spine = hips + 10 * np.column_stack([-np.sin(angle), np.cos(angle), np.zeros(11)])
    assert np.abs(places_of(clip) - np.stack([hips, spine], axis=1)).max() < 1e-9
    assert clip.head.fields["calibration_unit"] == "cm"
    assert clip.head.fields["dataframe_rate"] == "30"


def test_takes_are_told_and_read_one_by_one() -> None:
    files = {"fbx": source("a.fbx", fbx_text(("Walk", "Run", "Walk")))}
    assert isinstance(FBX, TakesReader)
    assert FBX.takes(files, ReadOptions()) == ("Walk", "Run", "Walk#2")
    first, second = (FBX.read(files, ReadOptions(take=take)) for take in ("Walk", "Run"))
    assert first.head.skeleton == second.head.skeleton
    assert frames(first) != frames(second)
    with pytest.raises(NotFoundError, match="no take 'Jump'"):
        FBX.read(files, ReadOptions(take="Jump"))


def test_another_rate_samples_between_keys() -> None:
    clip = read_clip("fbx", fbx_text(), rate=60)
    assert clip.frames == 21
    assert places_of(clip)[1, 0, 0] == pytest.approx(0.5)


@pytest.mark.parametrize(("unit", "name"), [(1.0, "cm"), (100.0, "m"), (2.54, "in"), (30.48, "ft"), (0.1, "mm")])
def test_unit_and_axes_are_stated(unit: float, name: str) -> None:
    clip = read_clip("fbx", fbx_text(unit=unit, up=2))
    assert clip.head.fields["calibration_unit"] == name
    assert clip.head.fields["global_axis_of_gravity"] == "Z"
    assert any("front axis" in notice.what for notice in clip.notices)


def test_a_unit_without_a_name_is_not_stated() -> None:
    clip = read_clip("fbx", fbx_text(unit=7.0))
    assert "calibration_unit" not in clip.head.fields
    assert any("has no name" in notice.what for notice in clip.notices)


def test_what_is_no_motion_is_refused() -> None:
    text = fbx_text()
    with pytest.raises(FormatError, match="has no skeleton"):
        read_clip("fbx", text.replace(b'"LimbNode"', b'"Null"'))
    with pytest.raises(FormatError, match="a skeleton of 2 joints and no motion"):
        read_clip("fbx", fbx_text(()))
    with pytest.raises(LimitError):
        read_clip("fbx", text, limits=Limits(frames=5))
    with pytest.raises(LimitError):
        read_clip("fbx", text, limits=Limits(joints=1))


def test_the_file_is_recognised_by_its_content() -> None:
    assert find_format("a.txt", fbx_text()[:4096]) == (FBX, "fbx")
    assert find_format("a", b"Kaydara FBX Binary  \0\x1a\0" + bytes(99)) == (FBX, "fbx")


@pytest.mark.slow
def test_damaged_files_are_read_or_refused() -> None:
    data = fbx_text()
    chance = np.random.default_rng(4)
    for _ in range(12):
        reads_or_refuses("fbx", spoil(data, chance))
    for end in np.linspace(0, len(data) - 1, 5).astype(int).tolist():
        reads_or_refuses("fbx", data[:end])


def test_a_crash_of_the_reader_is_a_refusal(monkeypatch: pytest.MonkeyPatch) -> None:
    from mcml.formats.scenes import apart

    monkeypatch.setattr(apart, "run_reader", lambda module, *arguments, **bounds: run(*arguments, **bounds))

    def run(*arguments: str, **bounds: object) -> object:
        from mcml.processes.programs import run_reader

        return run_reader("tests.processes.misbehaving", "crash", **bounds)  # type: ignore[arg-type]

    with pytest.raises((FormatError, LimitError)):
        read_clip("fbx", fbx_text())
