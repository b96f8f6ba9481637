"""C3D whose points must come out whatever header, parameters and analog channels say: from two other writers."""

from __future__ import annotations

import random
import tempfile

import ezc3d
import numpy as np
import pytest

from mcml.errors import FormatError, McmlError
from mcml.testing import frames
from tests.c3d_writer import DEC, INTEL, MIPS, Value, c3d_bytes
from tests.formats.test_c3d import clip_of, table


def places(count: int, points: int, seed: int = 0) -> np.ndarray:
    """(frames, points, 3) in single precision, no two alike, none zero."""
    rng = np.random.default_rng([seed, count, points])
    return rng.normal(300, 200, (count, points, 3)).astype(np.float32)


def by_ezc3d(points: np.ndarray, channels: int, samples: int, first: int = 0) -> bytes:
    count, markers = points.shape[:2]
    made = ezc3d.c3d()
    made["header"]["points"]["first_frame"] = first
    made["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    made["parameters"]["POINT"]["LABELS"]["value"] = [f"p{index}" for index in range(markers)]
    made["data"]["points"] = np.ones((4, markers, count))
    made["data"]["points"][:3] = points.transpose(2, 1, 0)
    if channels:
        made["parameters"]["ANALOG"]["RATE"]["value"] = [100.0 * samples]
        made["parameters"]["ANALOG"]["LABELS"]["value"] = [f"a{index}" for index in range(channels)]
        made["data"]["analogs"] = np.random.default_rng(1).normal(size=(1, channels, count * samples))
    with tempfile.NamedTemporaryFile(suffix=".c3d") as file:
        made.write(file.name)
        return file.read()


def check_ezc3d(count: int, markers: int, channels: int, samples: int) -> None:
    points = places(count, markers)
    clip = clip_of(by_ezc3d(points, channels, samples))
    assert np.array_equal(table(clip)[0], points.astype(np.float64)), (count, markers, channels, samples)
    assert not [notice for notice in clip.notices if "disagree" in notice.what or "count" in notice.what]


@pytest.mark.parametrize("channels", [0, 1, 2, 7])
def test_what_ezc3d_writes_is_read(channels: int) -> None:
    for count, markers, samples in ((1, 1, 1), (2, 3, 10), (700, 5, 1), (41, 300, 4)):
        check_ezc3d(count, markers, channels, samples)


@pytest.mark.fuzz
def test_all_that_ezc3d_writes_is_read() -> None:
    for count in (1, 2, 3, 7, 64, 700):
        for markers in (1, 2, 3, 16, 60, 256):
            for channels in (0, 1, 2, 3, 16, 64):
                for samples in (1, 2, 5, 20):
                    check_ezc3d(count, markers, channels, samples)


@pytest.mark.parametrize("processor", [INTEL, DEC, MIPS])
@pytest.mark.parametrize("channels", [0, 1, 6])
def test_every_form_gives_its_points(processor: int, channels: int) -> None:
    for seed, (count, markers, samples) in enumerate(((1, 1, 1), (9, 4, 3), (130, 2, 1))):
        rng = np.random.default_rng(seed)
        analog = rng.integers(-2000, 2000, (count, channels * samples)).astype(float)
        fourth = rng.choice([-1, 0, 5, 255, 0x0307], (count, markers))
        fourth[0, 0] = 5
        seen = fourth >= 0
        kinds = {"processor": processor, "analog": analog, "samples": samples}
        whole = rng.integers(-32768, 32767, (count, markers, 3))
        scale = float(np.float32(0.0833333))
        clip = clip_of(c3d_bytes(whole, fourth, scale=scale, **kinds))  # type: ignore[arg-type]
        found, residuals = table(clip)
        expected = (whole.astype(np.float32) * np.float32(scale)).astype(np.float64)
        assert np.array_equal(found[seen], expected[seen])
        assert np.isnan(found[~seen]).all()
        real = places(count, markers, seed)
        floats, others = table(clip_of(c3d_bytes(real, fourth, scale=-scale, **kinds)))  # type: ignore[arg-type]
        assert np.array_equal(floats[seen], real[seen].astype(np.float64))
        assert np.array_equal(residuals, others, equal_nan=True)
        in_units = (fourth & 0xFF).astype(np.float32) * np.float32(scale)
        assert np.array_equal(others[seen], in_units[seen].astype(np.float64))
        assert clip.frames == count


DISAGREEING: dict[str, tuple[dict[int, int], dict[str, Value | None]]] = {
    "the header has no analog words": ({3: 0, 10: 0}, {}),
    "the header counts channels, not words": ({3: 2}, {}),
    "the header has no samples per frame": ({10: 0}, {}),
    "the header has one sample per frame": ({10: 1}, {}),
    "ANALOG:USED is 0": ({}, {"ANALOG:USED": (2, (), [0])}),
    "ANALOG:USED counts words": ({}, {"ANALOG:USED": (2, (), [6])}),
    "ANALOG:RATE is the points'": ({}, {"ANALOG:RATE": (4, (), [100.0])}),
    "ANALOG:RATE is 0": ({}, {"ANALOG:RATE": (4, (), [0.0])}),
    "nothing is said of analog channels": ({}, {"ANALOG:USED": None, "ANALOG:RATE": None}),
    "ANALOG:SCALE is a scalar": ({}, {"ANALOG:SCALE": (4, (), [1.0]), "ANALOG:OFFSET": (2, (), [0])}),
    "ANALOG:SCALE has too few": ({}, {"ANALOG:SCALE": (4, (1,), [1.0]), "ANALOG:OFFSET": (2, (1,), [0])}),
    "ANALOG:OFFSET is a float": ({}, {"ANALOG:OFFSET": (4, (2,), [0.5, 0.5])}),
    "POINT:USED is 0": ({}, {"POINT:USED": (2, (), [0])}),
    "POINT:USED is one more": ({}, {"POINT:USED": (2, (), [5])}),
    "the header has no points": ({2: 0}, {}),
    "POINT:FRAMES is one more": ({}, {"POINT:FRAMES": (2, (), [71])}),
    "POINT:FRAMES is a float": ({}, {"POINT:FRAMES": (4, (), [70.0])}),
    "POINT:FRAMES is 65535": ({}, {"POINT:FRAMES": (2, (), [65535])}),
    "the header has one frame less": ({5: 69}, {}),
    "POINT:DATA_START is 0": ({}, {"POINT:DATA_START": (2, (), [0])}),
    "POINT:DATA_START is wrong": ({}, {"POINT:DATA_START": (2, (), [7])}),
    "the header has no start": ({9: 0}, {}),
    "POINT:SCALE has the wrong sign": ({}, {"POINT:SCALE": (4, (), [0.25])}),
    "POINT:SCALE is missing": ({}, {"POINT:SCALE": None}),
    "there are no labels": ({}, {"POINT:LABELS": None}),
}


@pytest.mark.parametrize("what", DISAGREEING)
def test_points_come_out_whatever_is_said(what: str) -> None:
    header, parameters = DISAGREEING[what]
    points = places(70, 4)
    analog = np.random.default_rng(2).normal(size=(70, 6))
    content = c3d_bytes(points, analog=analog, samples=3, header=header, parameters=parameters)
    clip = clip_of(content)
    assert np.array_equal(table(clip)[0], points.astype(np.float64))
    plain = clip_of(c3d_bytes(points, analog=analog, samples=3))
    assert not any("disagree" in notice.what for notice in plain.notices)


def test_the_receipt_says_which_statement_counts() -> None:
    points = places(70, 4)
    content = c3d_bytes(points, analog=np.ones((70, 6)), samples=3, parameters={"ANALOG:USED": (2, (), [0])})
    assert [notice.what for notice in clip_of(content).notices if "disagree" in notice.what] == [
        "header and parameters disagree (6 analog values a frame by the header and 0 analog values a frame by "
        "ANALOG:USED and the header's samples): 6 analog values a frame fit the size of the file and count"
    ]


def test_frames_that_are_announced_must_be_there() -> None:
    points = places(700, 4)
    content = c3d_bytes(points)
    with pytest.raises(FormatError, match="says it has 700 frames, and its data hold none"):
        clip_of(content[:1050])
    cut = clip_of(content[:-30_000])
    assert len(frames(cut)) == cut.frames == (len(content) - 30_000 - 1024) // 64
    assert any("700 frames" in notice.what and "these count" in notice.what for notice in cut.notices)


def test_frames_that_nobody_announced_are_read() -> None:
    """A recorder that broke off before it wrote its header again."""
    points = places(700, 4)
    for last, said in ((1, 1), (0, 0), (300, 300)):
        content = c3d_bytes(points, header={5: last}, parameters={"POINT:FRAMES": (2, (), [said])})
        clip = clip_of(content)
        assert np.array_equal(table(clip)[0], points.astype(np.float64))
        assert any(f"says it has {said} frames, its bytes hold 700" in notice.what for notice in clip.notices)


def test_what_stands_behind_the_data_is_said() -> None:
    points = places(40, 4)
    clip = clip_of(c3d_bytes(points, behind=b"something else " * 71))
    assert np.array_equal(table(clip)[0], points.astype(np.float64))
    assert any("1065 bytes follow the 40 frames" in notice.what for notice in clip.notices)
    # Blocks of zeros are nothing.
    assert not any("follow" in notice.what for notice in clip_of(c3d_bytes(points, behind=bytes(5000))).notices)


def test_more_frames_than_a_word_counts() -> None:
    count = 66_000
    points = places(count, 1)
    rest = np.concatenate([points[1:, 0], np.zeros((count - 1, 1), np.float32)], axis=1).astype("<f4").tobytes()
    fields: dict[str, Value | None] = {
        "TRIAL:ACTUAL_START_FIELD": (2, (2,), [1, 0]),
        "TRIAL:ACTUAL_END_FIELD": (2, (2,), [count - 65536, 1]),
    }
    for parameters in (fields, {"POINT:LONG_FRAMES": (4, (), [float(count)])}):
        capped: dict[str, Value | None] = {"POINT:FRAMES": (2, (), [65535]), **parameters}
        clip = clip_of(c3d_bytes(points[:1], header={5: 65535}, parameters=capped, behind=rest))
        assert np.array_equal(table(clip)[0], points.astype(np.float64))
        assert not clip.notices


def test_the_first_frame_is_numbered_by_who_counts_the_frames() -> None:
    points = places(70, 2)
    for start, end, first in ((91, 160, 91), (1, 500, 31)):
        fields: dict[str, Value | None] = {
            "TRIAL:ACTUAL_START_FIELD": (2, (2,), [start, 0]),
            "TRIAL:ACTUAL_END_FIELD": (2, (2,), [end, 0]),
        }
        clip = clip_of(c3d_bytes(points, first=31, parameters=fields))
        assert next(clip.blocks()).ids[0] == first


def test_numbers_that_are_none_are_missing_samples() -> None:
    points = places(5, 2)
    points[2, 1, 0], points[3, 0, 2] = np.nan, np.inf
    found = table(clip_of(c3d_bytes(points)))[0]
    gone = ~np.isfinite(points).all(axis=2)
    assert np.array_equal(np.isnan(found).any(axis=2), gone)
    assert frames(clip_of(c3d_bytes(points)))


def test_a_damaged_file_is_refused_in_words_of_ours() -> None:
    damaged_at_random(16, 60)


@pytest.mark.fuzz(seeds=4)
def test_many_damaged_files_are_refused_in_words_of_ours(seed: int) -> None:
    damaged_at_random(seed, 5000)


def damaged_at_random(seed: int, size: int) -> None:
    chance = random.Random(seed)
    whole = [c3d_bytes(places(30, 3), analog=np.ones((30, 4)), processor=kind) for kind in (INTEL, DEC, MIPS)]
    for _ in range(size):
        spoilt = bytearray(chance.choice(whole))
        for _ in range(chance.choice((1, 1, 3, 20))):
            spoilt[chance.randrange(1024 if chance.random() < 0.9 else len(spoilt))] = chance.randrange(256)
        try:
            clip = clip_of(bytes(spoilt[: chance.choice((len(spoilt), len(spoilt), chance.randrange(len(spoilt))))]))
        except McmlError:
            continue
        assert len(frames(clip)) == clip.frames
