"""A clip made fit for its target: a range, a frame rate, a size; and what formats may guess."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcml.errors import ConversionError, RequestError
from mcml.files.motion import convert, read
from mcml.files.reshape_clip import parse_range
from tests.builders import bvh
from tests.formats.readers.posing import places_of, read_clip
from tests.motion.bodies.made import clip_of, person


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    path = tmp_path / "walk.bvh"
    path.write_bytes(bvh(25))
    return path


def test_a_range_is_cut_and_a_rate_is_changed(walk: Path, tmp_path: Path) -> None:
    whole = read(walk)
    part = read(*convert(walk, tmp_path / "part.bvh", frames="5-9"))
    assert (part.frames() == whole.frames()[4:9]).all()
    slow = read(*convert(walk, tmp_path / "slow.bvh", fps=60))
    assert len(slow) == 13
    assert slow.frame_time == pytest.approx(1 / 60)
    assert np.allclose(slow.frames(), whole.frames()[::2], atol=1e-3)


def test_a_size_is_changed(walk: Path, tmp_path: Path) -> None:
    doubled = read(*convert(walk, tmp_path / "big.bvh", scale=2))
    before, after = (one.frames(space="positions") for one in (read(walk), doubled))
    assert np.allclose(after, 2 * before, atol=1e-6)


@pytest.mark.parametrize("text", ["0-3", "9-3", "abc", "3", "-"])
def test_what_is_no_range_is_refused(text: str) -> None:
    if text == "-":
        assert parse_range(text) == (1, None)
        return
    with pytest.raises(RequestError, match="is no range"):
        parse_range(text)


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("mm", 0.001), ("inch", 0.0254), ("m", 1.0)])
def test_a_person_of_unknown_unit_leaves_in_metres(tmp_path: Path, unit: str, metres: float) -> None:
    from dataclasses import replace

    from mcml.formats import WRITERS
    from mcml.motion.conventions.convert import scale
    from tests.formats.scenes.clips import timed

    clip = timed(clip_of(person(4, 10)))
    # A person of 1.8 m, in centimetres.
    clip = scale(clip, 0.01 / metres, unit=unit)
    fields = {name: text for name, text in clip.head.fields.items() if name not in ("calibration_unit",)}
    unknown = clip.with_head(replace(clip.head, fields=fields))
    data = b"".join(WRITERS["glb"].write(unknown, "glb"))
    known = b"".join(WRITERS["glb"].write(clip, "glb"))
    assert np.allclose(places_of(read_clip("glb", data)), places_of(read_clip("glb", known)), atol=1e-5)
    assert any(notice.kind == "guess" and f"taken as {unit}" in notice.what for notice in unknown.notices)


def test_guesses_can_be_refused(walk: Path, tmp_path: Path) -> None:
    with pytest.raises(ConversionError, match="states no unit and no up axis"):
        convert(walk, tmp_path / "walk.glb", guesses=False)
    assert convert(walk, tmp_path / "walk.glb", guesses=False, unit="cm", up="Y")
