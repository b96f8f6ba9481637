"""Presets of exports: the format, unit and axes of a program, with the user's own options first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError, McmlError, UnsupportedError
from mcml.files.motion import convert, read
from mcml.files.presets import PRESETS, choose_shape, find_preset, fit_shape
from mcml.formats import WRITERS
from mcml.motion.clip import ClipStream
from mcml.motion.conventions.convert import scale, turn_up
from tests.formats.readers.posing import places_of
from tests.formats.scenes.clips import timed
from tests.motion.bodies.made import clip_of, person


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    """A person of 1.8 m in centimetres with Y up, of which the file states neither."""
    path = tmp_path / "walk.bvh"
    path.write_bytes(person(4, 10))
    return path


def test_every_preset_names_formats_that_hold_such_clips() -> None:
    for preset in PRESETS.values():
        assert WRITERS[preset.bodies.format].bodies
        # Formats of joints hold the skeleton that markers make.
        assert WRITERS[preset.markers.format].markers or preset.markers == preset.bodies
        assert all(len(WRITERS[shape.format].parts) == 1 for shape in (preset.bodies, preset.markers))


def test_blender_gets_metres_of_a_guessed_person(walk: Path, tmp_path: Path) -> None:
    (written,) = convert(walk, tmp_path / "out", for_="blender")
    assert written == tmp_path / "out.bvh"
    before, after = (read(path).frames(space="positions") for path in (walk, written))
    assert np.allclose(after, before / 100, atol=1e-6)


def test_the_unit_of_the_input_and_the_format_of_the_user_win(walk: Path, tmp_path: Path) -> None:
    (written,) = convert(walk, tmp_path / "out", for_="blender", unit="mm", up="Y")
    assert np.allclose(read(written).frames(space="positions"), read(walk).frames(space="positions") / 1000, atol=1e-6)
    (named,) = convert(walk, tmp_path / "out.htr", for_="blender", unit="mm", up="Y")
    assert named.read_bytes().startswith(b"[Header]")
    (said,) = convert(walk, tmp_path / "other", to="trc", for_="blender", unit="mm", up="Y")
    assert said == tmp_path / "other"
    assert b"\tm\t" in said.read_bytes()


@pytest.mark.parametrize("unit", ["cm", "m", "inch"])
@pytest.mark.parametrize("up", ["X", "Y", "Z"])
def test_a_stated_unit_and_axis_become_those_of_the_program(unit: str, up: str) -> None:
    clip = timed(clip_of(person(4, 10)))
    metres = {"cm": 0.01, "m": 1.0, "inch": 0.0254}[unit]
    fields = {**clip.head.fields, "calibration_unit": "cm", "global_axis_of_gravity": "Y"}
    clip = clip.with_head(replace(clip.head, fields=fields))
    stated = turn_up(scale(clip, 0.01 / metres, unit=unit), "Y", up)
    preset = find_preset("blender")
    shape = choose_shape(preset, stated.head.skeleton)
    fitted = fit_shape(stated, shape, preset)
    assert np.allclose(places_of(fitted), places_of(clip) / 100, atol=1e-9)
    assert fitted.head.fields["calibration_unit"] == "m"
    assert [notice.what for notice in fitted.notices][-1] == "for Blender: BVH, lengths in m, Y up"
    assert not any(notice.kind == "guess" for notice in fitted.notices)


def test_guesses_are_told_or_refused() -> None:
    clip, preset = timed(clip_of(person(4, 10))), find_preset("motionbuilder")
    shape = choose_shape(preset, clip.head.skeleton)
    fitted = fit_shape(clip, shape, preset)
    assert sum(notice.kind == "guess" for notice in fitted.notices) == 2
    with pytest.raises(ConversionError, match="no unit and no up axis"):
        fit_shape(clip, shape, preset, guesses=False)


def test_a_body_of_no_persons_size_is_left_and_the_notice_promises_no_unit() -> None:
    clip, preset = scale(timed(clip_of(person(4, 10))), 1e-4), find_preset("blender")
    fitted = fit_shape(clip, choose_shape(preset, clip.head.skeleton), preset)
    assert np.allclose(places_of(fitted), places_of(clip))
    assert [notice.what for notice in fitted.notices][-1] == "for Blender: BVH, Y up"
    assert any("Blender takes them as m" in notice.what for notice in fitted.notices)


def test_markers_leave_in_the_format_of_markers(walk: Path, tmp_path: Path) -> None:
    (points,) = convert(walk, tmp_path / "points.trc", unit="cm", up="Y")
    (written,) = convert(points, tmp_path / "out", for_="opensim", up="Y")
    assert written.suffix == ".trc"
    assert np.allclose(read(written).frames(), read(points).frames() / 100, atol=1e-4)
    assert convert(points, tmp_path / "scene", for_="blender")[0].suffix == ".glb"


def test_what_is_unknown_or_unchanged_by_presets_is_refused(walk: Path, tmp_path: Path) -> None:
    with pytest.raises(UnsupportedError, match=r"No preset is called 'blendr'\. Use one of: blender"):
        convert(walk, tmp_path / "out", for_="blendr")
    with pytest.raises(UnsupportedError, match="change no mcml files"):
        convert(walk, tmp_path / "out.mcml", for_="blender")
    with pytest.raises(McmlError):
        convert(walk, tmp_path / "out")
    assert not list(tmp_path.glob("out*"))


def test_an_empty_clip_is_fitted_at_rest() -> None:
    clip, preset = timed(clip_of(person(4, 10))), find_preset("blender")
    empty = ClipStream(clip.head, lambda: iter(()), 0)
    fitted = fit_shape(empty, choose_shape(preset, clip.head.skeleton), preset)
    assert fitted.head.fields["calibration_unit"] == "m"
