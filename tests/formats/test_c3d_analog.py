"""C3D: values of analog channels, from files whose words the test writes itself, and from ezc3d's reading."""

from __future__ import annotations

import io
import json
import math
import tracemalloc
from contextlib import suppress
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.errors import McmlError
from mcml.formats.c3d.analog import Channels, read_channels
from tests.c3d_writer import DEC, INTEL, MIPS, Value, c3d_bytes, texts

MACHINES = [INTEL, DEC, MIPS]
UNSIGNED: Value = (-1, (8,), b"UNSIGNED")
MISREAD_BY_EZC3D = {"shd01.c3d"}
"""Of unsigned offsets over 32,767, ezc3d takes the size of the signed word."""


def channels_of(data: bytes) -> Channels:
    return read_channels(io.BytesIO(data))


def file_of(
    raw: np.ndarray, samples: int = 1, *, points: int = 2, header: dict[int, int] | None = None, **said: Value | None
) -> bytes:
    """A file of integers: raw (frames, samples × channels), parameters of ANALOG by their names."""
    names = [f"p{index}" for index in range(points)] or ["-"]
    parameters: dict[str, Value | None] = {f"ANALOG:{name}": value for name, value in said.items()}
    if not points:
        parameters["POINT:LABELS"] = None
    places = np.ones((len(raw), points, 3))
    return c3d_bytes(
        places, scale=0.1, analog=raw, samples=samples, labels=names, header=header, parameters=parameters, first=7
    )


@pytest.mark.parametrize("processor", MACHINES)
@pytest.mark.parametrize("is_real", [False, True])
@given(data=st.data())
@settings(max_examples=15, deadline=None)
def test_values_of_all_machines(processor: int, is_real: bool, data: st.DataObject) -> None:
    frames, count, samples = (data.draw(st.integers(1, most)) for most in (5, 4, 3))
    numbers = st.lists(
        st.integers(-32_768, 32_767), min_size=frames * samples * count, max_size=frames * samples * count
    )
    raw = np.array(data.draw(numbers), dtype=np.float64).reshape(frames, samples * count)
    scales = data.draw(st.lists(st.sampled_from([0.5, -2.0, 1.0, 0.25]), min_size=count, max_size=count))
    offsets = data.draw(st.lists(st.integers(-3000, 3000), min_size=count, max_size=count))
    channels = channels_of(
        c3d_bytes(
            np.ones((frames, 3, 3)),
            scale=-0.1 if is_real else 0.1,
            processor=processor,
            analog=raw,
            samples=samples,
            first=11,
            parameters={
                "ANALOG:SCALE": (4, (count,), scales),
                "ANALOG:OFFSET": (2, (count,), offsets),
                "ANALOG:GEN_SCALE": (4, (), [4.0]),
            },
        )
    )
    assert (len(channels), channels.samples, channels.frames, channels.first) == (count, samples, frames, 11)
    assert channels.rate == 100.0 * samples
    table = raw.reshape(frames * samples, count)
    assert np.array_equal(channels.read_raw(), table)
    assert np.array_equal(channels.read(), (table - offsets) * np.array(scales) * 4.0)
    first = data.draw(st.integers(0, frames))
    chosen = [count - 1, 0]
    expected = channels.read()[first * samples : (first + 2) * samples, chosen]
    assert np.array_equal(channels.read(first, 2, chosen), expected)


@pytest.mark.parametrize("scale", [0.1, -0.1])
def test_unsigned_offsets_and_values(scale: float) -> None:
    """Converters of 16 bits have 0 volts at 32,768: as a signed word this is -32,768."""
    raw = np.array([[32_768.0, 40_000.0], [65_535.0, 10.0]])
    said: dict[str, Value | None] = {
        "ANALOG:FORMAT": UNSIGNED,
        "ANALOG:OFFSET": (2, (2,), [32_768, 32_784]),
        "ANALOG:SCALE": (4, (2,), [1.0, 1.0]),
    }
    channels = channels_of(c3d_bytes(np.ones((2, 1, 3)), scale=scale, analog=raw, parameters=said))
    assert channels.read().tolist() == [[0.0, 7_216.0], [32_767.0, -32_774.0]]
    said["ANALOG:OFFSET"] = (4, (2,), [-32_768.0, 32_784.0])
    channels = channels_of(c3d_bytes(np.ones((2, 1, 3)), scale=scale, analog=raw, parameters=said))
    assert channels.read()[0].tolist() == [0.0, 7_216.0]


def test_signed_values_without_a_format() -> None:
    channels = channels_of(file_of(np.array([[-5.0, 7.0]]), OFFSET=(2, (2,), [-10, 2]), SCALE=(4, (2,), [1.0, 1.0])))
    assert channels.read().tolist() == [[5.0, 5.0]]


def test_offsets_may_be_floats() -> None:
    channels = channels_of(file_of(np.array([[10.0]]), OFFSET=(4, (1,), [2.5]), SCALE=(4, (1,), [2.0])))
    assert channels.read().tolist() == [[15.0]]


@pytest.mark.parametrize("scale", [0.1, -0.1])
def test_a_header_of_0_samples_means_1(scale: float) -> None:
    places = np.random.default_rng(1).integers(-500, 500, (40, 3, 3)).astype(float)
    raw = np.arange(80.0).reshape(40, 2)
    said: dict[str, Value | None] = {
        "ANALOG:RATE": None,
        "ANALOG:LABELS": texts("a", "b"),
        "ANALOG:SCALE": (4, (2,), [1.0, 1.0]),
        "ANALOG:OFFSET": (2, (2,), [0, 0]),
    }
    channels = channels_of(c3d_bytes(places, scale=scale, analog=raw, header={10: 0}, parameters=said))
    assert (channels.samples, channels.rate, channels.layout.points) == (1, 100.0, 3)
    assert np.array_equal(channels.read(), raw)
    assert not channels.notices
    # Older files state no channels either.
    said["ANALOG:USED"] = (2, (), [0])
    channels = channels_of(c3d_bytes(places, scale=scale, analog=raw, header={10: 0}, parameters=said))
    assert np.array_equal(channels.read(), raw)


def test_analog_channels_without_points() -> None:
    raw = np.arange(2400.0).reshape(200, 12)
    channels = channels_of(file_of(raw, 6, points=0, RATE=(4, (), [600.0])))
    assert (len(channels), channels.samples, channels.frames, channels.first) == (2, 6, 200, 7)
    assert np.array_equal(channels.read(), raw.reshape(-1, 2))


def test_points_without_analog_channels_and_files_without_data() -> None:
    channels = channels_of(file_of(np.zeros((3, 0))))
    assert (len(channels), channels.frames, channels.read().shape) == (0, 3, (3, 0))
    assert math.isnan(channels.rate)
    channels = channels_of(file_of(np.zeros((0, 0)), points=0))
    assert (len(channels), channels.frames, channels.read().shape) == (0, 0, (0, 0))


def test_fewer_scales_and_offsets_than_channels_are_told() -> None:
    channels = channels_of(file_of(np.array([[3.0, 5.0]]), SCALE=(4, (1,), [2.0]), OFFSET=(2, (1,), [1])))
    assert channels.read().tolist() == [[4.0, 5.0]]
    told = [notice.what for notice in channels.notices]
    assert "ANALOG:SCALE has 1 of 2 numbers: 1 counts for the others" in told
    assert "ANALOG:OFFSET has 1 of 2 numbers: 0 counts for the others" in told


def test_names_and_units() -> None:
    said = {
        "LABELS": texts("Fx  ", "Fx", "", "EMG\x01"),
        "DESCRIPTIONS": texts("left", "right"),
        "UNITS": texts("N", "Nmm", "V"),
    }
    channels = channels_of(file_of(np.zeros((1, 4)), **said))
    assert channels.labels == ("Fx", "Fx#2", "unnamed", "EMG")
    assert channels.descriptions == ("left", "right", "", "")
    assert channels.units == ("N", "Nmm", "V", "")
    assert channels_of(file_of(np.zeros((1, 2)))).labels == ("unnamed", "unnamed#2")


def test_more_than_255_channels() -> None:
    """Names and numbers beyond 255 are in further parameters."""
    names = [f"a{index}" for index in range(600)]
    said: dict[str, Value | None] = {}
    for first, number in ((0, ""), (255, "2"), (510, "3")):
        count = len(names[first : first + 255])
        said[f"LABELS{number}"] = texts(*names[first : first + 255])
        said[f"SCALE{number}"] = (4, (count,), [2.0 + first] * count)
        said[f"OFFSET{number}"] = (2, (count,), [-first] * count)
    channels = channels_of(file_of(np.ones((2, 600)), **said))
    assert channels.labels == tuple(names)
    assert channels.read()[0, [0, 254, 255, 509, 510, 599]].tolist() == [
        2,
        2,
        257 * 256,
        257 * 256,
        512 * 511,
        512 * 511,
    ]
    assert not channels.notices


def test_rates_and_counts_that_contradict_each_other() -> None:
    channels = channels_of(file_of(np.zeros((5, 4)), 2, RATE=(4, (), [1234.0])))
    assert channels.rate == 200.0
    assert any("200 samples a second count" in notice.what for notice in channels.notices)
    # The header says 4 samples: of 4 values and 2 channels there are 2.
    channels = channels_of(file_of(np.zeros((5, 4)), 2, header={10: 4}))
    assert (len(channels), channels.samples) == (2, 2)
    assert any("2 channels of 2 samples" in notice.what for notice in channels.notices)


@pytest.mark.parametrize("samples", [1, 2, 3, 10])
@pytest.mark.parametrize("block", [1, 3, 100])
def test_means_around_the_instants_of_frames(samples: int, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where frames are read a few at a time; at the ends of the file fewer samples count."""
    monkeypatch.setattr(Channels, "block", block)
    values = np.random.default_rng(5).normal(0, 9, 7 * samples).astype(np.float32)
    points = np.zeros((7, 1, 3))
    data = c3d_bytes(points, analog=values.reshape(7, samples), samples=samples)
    channels, half = channels_of(data), samples // 2
    expected = [values[max(0, at - half) : at + half + 1].mean(dtype=float) for at in range(0, 7 * samples, samples)]
    np.testing.assert_allclose(channels.means([0], around_instant=True)[:, 0], expected, rtol=1e-12)
    np.testing.assert_allclose(channels.means([0])[:, 0], values.reshape(7, samples).mean(axis=1, dtype=float))


def test_places_outside_of_the_file_are_refused() -> None:
    channels = channels_of(file_of(np.zeros((2, 2))))
    with pytest.raises(ValueError, match="counted from 0"):
        channels.read(0, 1, [2])
    with pytest.raises(ValueError, match="from 0"):
        channels.read(-1)
    assert channels.read(5).shape == (0, 2)


@given(
    used=st.one_of(st.integers(0, 65_535).map(float), st.floats(width=32)),
    samples=st.integers(0, 65_535),
    values=st.integers(0, 65_535),
    frames=st.integers(0, 65_535),
)
@settings(max_examples=60, deadline=None)
def test_untrue_counts_neither_exhaust_memory_nor_fail_otherwise(
    used: float, samples: int, values: int, frames: int
) -> None:
    data = file_of(np.zeros((3, 2)), USED=(4, (), [used]), header={10: samples, 3: values, 5: frames})
    tracemalloc.start()
    try:
        with suppress(McmlError):
            channels = channels_of(data)
            assert channels.read(0, 10).shape[1] == len(channels) <= 65_535
        assert tracemalloc.get_traced_memory()[1] < 64 << 20
    finally:
        tracemalloc.stop()


def test_real_files_as_ezc3d_reads_them(shared: Path) -> None:
    compared = 0
    for path in sorted([*shared.glob("c3d/*/*.c3d"), *shared.glob("lab/*.c3d")]):
        if path.name == "bad_parameter_section.c3d":
            continue  # ezc3d takes half a minute to refuse it.
        try:
            expected = ezc3d.c3d(str(path))["data"]["analogs"][0].T
        except (RuntimeError, ValueError, OSError):
            continue
        with path.open("rb") as stream:
            channels = read_channels(stream)
            if path.name in MISREAD_BY_EZC3D or not len(channels):
                assert len(channels) == (expected.shape[1] if len(expected) else 0), path.name
                continue
            assert np.array_equal(channels.read(), expected), path.name
            compared += 1
    assert compared > 10


def test_real_files_of_a_laboratory(shared: Path) -> None:
    expected = json.loads((shared / "lab/expected.json").read_text())
    for name in (name for name in expected if name.endswith(".c3d")):
        with (shared / "lab" / name).open("rb") as stream:
            channels = read_channels(stream)
            rate = 0.0 if math.isnan(channels.rate) else channels.rate
            assert [len(channels), rate] == expected[name]["analog"], name
            if len(channels):
                assert (channels.frames, channels.first) == (expected[name]["frames"], expected[name]["first_frame"])
