"""C3D that is written from C3D keeps analog channels, force plates and parameters of the file, frame by frame."""

from __future__ import annotations

import io
import tracemalloc
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.errors import McmlError
from mcml.files.convert_files import convert_files
from mcml.files.limits import FileLimits
from mcml.formats import FORMATS
from mcml.formats.c3d.analog import Channels, read_channels
from mcml.formats.c3d.parameters import read_statements
from mcml.formats.c3d.plates import plates_of
from mcml.formats.format import SourceFile
from mcml.laboratory.force_plates import PlateForces, plate_forces
from mcml.motion.clip import ClipStream, FrameBlock, full_shape
from mcml.motion.conventions.convert import scale as multiply
from mcml.motion.conventions.convert import turn_up
from mcml.motion.frames import rows_of
from mcml.motion.markers import marker_skeleton
from mcml.testing import read
from tests.c3d_writer import DEC, INTEL, MIPS, Value, c3d_bytes, kept_c3d, texts

C3D = FORMATS["c3d"]
LOAD = [-40.0, 80, -700, -140_000, 70_000, 11_000]
CORNERS = [[600.0, 300, 5], [600, -300, 5], [-400, -300, 5], [-400, 300, 5]]
READ_OTHERWISE_BY_EZC3D = {
    "type1.C3D",
    "Dance.c3d",
    "Eb015si.c3d",
    "Eb015sr.c3d",
    "mocap36.c3d",
    "badParameterOffset.c3d",
}
"""It loses its place in the first, and refuses the others; see test_c3d.py."""


def channels_of(data: bytes) -> Channels:
    return read_channels(io.BytesIO(data))


def convert(data: bytes, **options: object) -> tuple[bytes, list[str]]:
    """The file after a conversion from C3D to C3D, and the words of its notices."""
    source = SourceFile("trial.c3d", io.BytesIO(data))
    with convert_files([source], "c3d", FileLimits(), **options) as done:  # type: ignore[arg-type]
        content = b"".join(done.files[".c3d"])
        return content, [notice.what for notice in done.notices()]


def write(data: bytes, rows: list[int], ids: list[int] | list[str] | None = None) -> tuple[bytes, list[str]]:
    """The file with some of its frames in another order, under other numbers."""
    clip = read(C3D, {"c3d": data})

    def blocks() -> list[FrameBlock]:
        (block,) = clip.blocks()
        parts = [rows_of(block, row, row + 1) for row in rows]
        if ids is None:
            return parts
        numbers = [[name] if isinstance(name, str) else np.array([name], np.int64) for name in ids]
        return [replace(part, ids=number) for part, number in zip(parts, numbers, strict=True)]

    stream = ClipStream(clip.head, lambda: iter(blocks()), len(rows), clip.notices, kept_c3d(data))
    return b"".join(C3D.write(stream, "c3d")), [notice.what for notice in stream.notices]


def forces_of(data: bytes) -> list[PlateForces]:
    channels = channels_of(data)
    return [plate_forces(plate, channels.read(channels=plate.channels)) for plate in plates_of(channels)]


def trial(frames: int = 12, samples: int = 2, first: int = 91, **said: Value | None) -> bytes:
    """A trial with a loaded plate of type 2 and a channel beside it."""
    chance = np.random.default_rng(3)
    analog = np.tile([*LOAD, 0.0], (frames, samples, 1)) + chance.normal(0, 1, (frames, samples, 7))
    parameters: dict[str, Value | None] = {
        "ANALOG:LABELS": texts("Fx", "Fy", "Fz", "Mx", "My", "Mz", "EMG"),
        "ANALOG:DESCRIPTIONS": texts(*["a plate"] * 6, "a muscle"),
        "ANALOG:UNITS": texts("N", "N", "N", "Nmm", "Nmm", "Nmm", "V"),
        "ANALOG:SCALE": (4, (7,), [1.0] * 7),
        "ANALOG:OFFSET": (2, (7,), [0] * 7),
        "FORCE_PLATFORM:USED": (2, (), [1]),
        "FORCE_PLATFORM:TYPE": (2, (1,), [2]),
        "FORCE_PLATFORM:ZERO": (2, (2,), [1, 10]),
        "FORCE_PLATFORM:CORNERS": (4, (3, 4, 1), np.ravel(CORNERS).tolist()),
        "FORCE_PLATFORM:ORIGIN": (4, (3, 1), [1.0, 2.0, -40.0]),
        "FORCE_PLATFORM:CHANNEL": (2, (6, 1), [1, 2, 3, 4, 5, 6]),
        "POINT:Y_SCREEN": texts("+Z"),
        "SUBJECTS:NAMES": texts("Ann"),
        "PROCESSING:LLegLength": (4, (1,), [912.5]),
        "ANALYSIS:VALUES": (4, (2,), [1.25, -3.0]),
        "MANUFACTURER:VERSION": (2, (3,), [1, 2, 65_535]),
        "TRIAL:CAMERA_RATE": (4, (), [100.0]),
        "TRIAL:X_DIRECTION": (2, (), [1]),
        "SEG:MAX_RESID": (4, (), [3.0]),
    } | {name.replace("__", ":"): value for name, value in said.items()}
    points = chance.normal(0, 500, (frames, 2, 3)).astype(np.float32)
    raw = analog.astype(np.float32).reshape(frames, -1)
    labels = ["LASI", "RASI"]
    return c3d_bytes(points, labels=labels, analog=raw, samples=samples, first=first, parameters=parameters)


@pytest.mark.parametrize("processor", [INTEL, DEC, MIPS])
@pytest.mark.parametrize("is_real", [False, True])
@pytest.mark.parametrize("is_unsigned", [False, True])
@given(data=st.data())
@settings(max_examples=12, deadline=None)
def test_samples_follow_their_frames(processor: int, is_real: bool, is_unsigned: bool, data: st.DataObject) -> None:
    frames, count, samples = (data.draw(st.integers(1, most)) for most in (9, 4, 3))
    low, high = (0, 65_535) if is_unsigned else (-32_768, 32_767)
    numbers = st.lists(st.integers(low, high), min_size=frames * samples * count, max_size=frames * samples * count)
    raw = np.array(data.draw(numbers), dtype=np.float64).reshape(frames, samples * count)
    scales = data.draw(st.lists(st.sampled_from([0.5, -2.0, 0.1]), min_size=count, max_size=count))
    offsets = data.draw(st.lists(st.integers(low, high), min_size=count, max_size=count))
    said: dict[str, Value | None] = {
        "ANALOG:SCALE": (4, (count,), scales),
        "ANALOG:OFFSET": (2, (count,), offsets),
        "ANALOG:GEN_SCALE": (4, (), [0.3]),
        "ANALOG:FORMAT": (-1, (8,), b"UNSIGNED") if is_unsigned else None,
    }
    points, scale = np.ones((frames, 3, 3)), -0.1 if is_real else 0.1
    content = c3d_bytes(
        points, scale=scale, processor=processor, analog=raw, samples=samples, first=11, parameters=said
    )
    rows = data.draw(st.lists(st.integers(0, frames - 1), min_size=1, max_size=12))
    before, after = channels_of(content), channels_of(write(content, rows)[0])
    assert (after.labels, after.samples, after.rate) == (before.labels, before.samples, before.rate)
    expected = before.read().reshape(frames, samples, count)[rows].reshape(-1, count)
    assert after.read().tobytes() == expected.tobytes()
    assert after.frames == len(rows)


def test_unsigned_offsets_are_written_for_programs_without_them() -> None:
    raw = np.array([[32_768.0, 40_000.0, 7.0], [65_535.0, 10.0, 9.0]])
    said: dict[str, Value | None] = {
        "ANALOG:FORMAT": (-1, (8,), b"UNSIGNED"),
        "ANALOG:OFFSET": (2, (3,), [32_768, 65_000, 5]),
        "ANALOG:SCALE": (4, (3,), [1.0] * 3),
    }
    data = c3d_bytes(np.ones((2, 1, 3)), scale=0.1, analog=raw, parameters=said)
    content, _ = convert(data)
    parameters = read_statements(io.BytesIO(content), []).parameters
    assert parameters["ANALOG:FORMAT"].texts() == [b"SIGNED"]
    assert parameters["ANALOG:OFFSET"].numbers(signed=True) == [0.0, 0.0, 5.0]
    assert channels_of(content).read().tolist() == [[0.0, -25_000.0, 2.0], [32_767.0, -64_990.0, 4.0]]


@pytest.mark.parametrize(("offsets", "kind"), [([2.0, -3.0], 2), ([2.5, 1.0], 4), ([40_000.0, 1.0], 4)])
def test_offsets_that_are_floats_become_words_if_they_are_whole(offsets: list[float], kind: int) -> None:
    said: dict[str, Value | None] = {"ANALOG:OFFSET": (4, (2,), offsets), "ANALOG:SCALE": (4, (2,), [1.0, 2.0])}
    data = c3d_bytes(np.ones((2, 1, 3)), scale=0.1, analog=np.array([[5.0, 6.0], [7.0, -8.0]]), parameters=said)
    content, _ = convert(data)
    assert channels_of(content).read().tobytes() == channels_of(data).read().tobytes()
    assert read_statements(io.BytesIO(content), []).parameters["ANALOG:OFFSET"].kind == kind


def test_frames_that_are_not_of_the_file_have_nan() -> None:
    data = trial()
    whole = channels_of(data).read().reshape(12, 2, 7)
    for ids in ([92, 20_000_000, 102, 50], ["92", "x", "102", "y"]):
        content, told = write(data, [0, 1, 2, 3], ids)
        values = channels_of(content).read().reshape(4, 2, 7)
        numbers = isinstance(ids[0], int)
        assert np.isnan(values[[1, 3] if numbers else [0, 1, 2, 3]]).all()
        if numbers:
            assert np.array_equal(values[[0, 2]], whole[[1, 11]])
        unknown = 2 if numbers else 4
        assert f"{unknown} frames are not of the source file: their analog samples are missing (NaN)" in told


def test_plates_and_parameters_after_a_trim() -> None:
    data = trial()
    content, told = convert(data, frames="4-9")
    (before,), (after,) = forces_of(data), forces_of(content)
    for name in ("force", "centre_of_pressure", "free_moment"):
        assert getattr(after, name).tobytes() == getattr(before, name)[6:18].tobytes()
    assert np.isfinite(after.centre_of_pressure).all()
    own, new = (read_statements(io.BytesIO(file), []) for file in (data, content))
    counts = {"POINT:FRAMES", "POINT:DATA_START", "FORCE_PLATFORM:ZERO", "POINT:SCALE"}
    for name, parameter in own.parameters.items():
        if name not in counts:
            again = new.parameters[name]
            assert (again.numbers(), again.texts()) == (parameter.numbers(), parameter.texts()), name
    assert new.parameters["PROCESSING:LLEGLENGTH"].spelling == "PROCESSING:LLegLength"
    assert new.parameters["FORCE_PLATFORM:ZERO"].numbers() == [0.0, 0.0]
    assert new.long("TRIAL:ACTUAL_START_FIELD") == 94
    assert new.long("TRIAL:ACTUAL_END_FIELD") == 99
    assert any("FORCE_PLATFORM:ZERO is written as 0" in words for words in told)
    assert "7 analog channels and 1 force plate are written from the source file, without later edits" in told
    whole, told = convert(data)
    assert read_statements(io.BytesIO(whole), []).numbers("FORCE_PLATFORM:ZERO") == [1.0, 10.0]
    assert not any("ZERO" in words for words in told)


def as_after(scale: float, data: bytes, **turn: str) -> tuple[bytes, list[str]]:
    """The file at another scale, or with another axis up, as exports make it."""
    clip = read(C3D, {"c3d": data})
    clip.original = kept_c3d(data)
    if scale != 1.0:
        clip = multiply(clip, scale, unit="m")
    if turn:
        clip = turn_up(clip, turn["start"], turn["end"])
    return b"".join(C3D.write(clip, "c3d")), [notice.what for notice in clip.notices]


@pytest.mark.parametrize("end", ["X", "Y"])
@pytest.mark.parametrize("scale", [0.001, 1.0])
def test_plates_follow_the_unit_and_the_up_axis(end: str, scale: float) -> None:
    """The plate stays below the markers: force and place turn as points do, in metres they are the same."""
    data = trial()
    content, _ = as_after(scale, data, start="Z", end=end)
    (before,), (after,) = forces_of(data), forces_of(content)
    third = {"X": 1, "Y": 0}[end]
    for name in ("force", "centre_of_pressure"):
        was, now = getattr(before, name), getattr(after, name)
        np.testing.assert_allclose(now[:, "XYZ".index(end)], was[:, 2], rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(now[:, third], was[:, third], rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(now[:, 2], -was[:, "XYZ".index(end)], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(after.free_moment, before.free_moment, rtol=1e-4)
    assert channels_of(content).read().tobytes() == channels_of(data).read().tobytes()
    parameters = read_statements(io.BytesIO(content), []).parameters
    assert "SEG:MAX_RESID" not in parameters
    assert "TRIAL:X_DIRECTION" not in parameters
    assert "TRIAL:CAMERA_RATE" in parameters


def test_turns_follow_each_other() -> None:
    data = trial()
    clip = read(C3D, {"c3d": data})
    clip.original = kept_c3d(data)
    there = turn_up(turn_up(clip, "Z", "Y"), "Y", "X")
    back = turn_up(turn_up(there, "X", "Y"), "Y", "Z")
    assert there.original is not None
    assert there.original.is_turned
    assert back.original is not None
    assert not back.original.is_turned


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fps": 50}, "7 analog channels and 1 force plate of the source file are left out: the frames were resampled"),
        ({"scale": 1.5}, "1 force plate of the source file is left out: the size of the clip was changed"),
    ],
)
def test_data_that_cannot_follow_are_left_out_with_a_notice(options: dict[str, object], words: str) -> None:
    content, told = convert(trial(), **options)
    assert any(words in text for text in told), told
    channels = channels_of(content)
    assert len(channels) == (7 if "scale" in options else 0)
    assert not plates_of(channels)
    assert read_statements(io.BytesIO(content), []).texts("SUBJECTS:NAMES") == [b"Ann"]


def test_a_clip_of_another_rate_has_no_samples_of_the_file() -> None:
    data = trial()
    clip = read(C3D, {"c3d": data})
    head = replace(clip.head, fields=clip.head.fields | {"dataframe_rate": "50"})
    stream = replace(clip, head=head, original=kept_c3d(data))
    assert not len(channels_of(b"".join(C3D.write(stream, "c3d"))))
    assert any("it has 100 frames a second, the clip 50" in notice.what for notice in stream.notices)


def test_moments_of_unknown_units_do_not_change_their_meaning() -> None:
    data = trial(ANALOG__UNITS=None)
    content, told = as_after(0.001, data)
    assert not plates_of(channels_of(content))
    assert any("force plate of the source file is left out" in words for words in told)
    content, _ = as_after(1.0, data)
    assert len(plates_of(channels_of(content))) == 1


@pytest.mark.parametrize(
    ("blocks", "descriptions", "others", "channels"), [(90, 1, 1, 7), (150, 0, 1, 7), (210, 0, 0, 7), (245, 0, 0, 0)]
)
def test_parameters_that_do_not_fit(blocks: int, descriptions: int, others: int, channels: int) -> None:
    """Descriptions go first, then other groups, then analog channels; markers are never lost."""
    room: Value = (-1, (127, 255), b"x" * 127 * 255)
    data = trial(ANALOG__DESCRIPTIONS=room, OTHER__NOTES=room, FORCE_PLATFORM__NOTES=(-1, (127, 70), b"y" * 8890))
    clip = read(C3D, {"c3d": data})
    (block,) = clip.blocks()
    needed = blocks * 512 // 128
    skeleton = marker_skeleton([f"{index:0127}" for index in range(needed)])
    values = np.zeros((len(block), 3 * needed))
    more = FrameBlock(values, skeleton.columns(), (full_shape(skeleton.columns()),), block.ids)
    head = replace(clip.head, skeleton=skeleton)
    stream = ClipStream(head, lambda: iter([more]), len(block), clip.notices, kept_c3d(data))
    content = b"".join(C3D.write(stream, "c3d"))
    said = read_statements(io.BytesIO(content), [])
    assert len(read(C3D, {"c3d": content}).head.skeleton) == needed
    assert ("ANALOG:DESCRIPTIONS" in said.parameters, "OTHER:NOTES" in said.parameters) == (descriptions, others)
    assert len(channels_of(content)) == channels
    told = " ".join(notice.what for notice in stream.notices)
    assert ("descriptions of the source file are left out" in told) == (not descriptions)
    assert ("groups of the source file are left out" in told) == (not others)
    assert ("7 analog channels are left out" in told) == (not channels)


def test_an_original_that_cannot_be_read_is_told() -> None:
    clip = read(C3D, {"c3d": trial()})
    clip.original = kept_c3d(b"C3D")
    assert not len(channels_of(b"".join(C3D.write(clip, "c3d"))))
    assert any("analog channels and groups of the source file are left out" in notice.what for notice in clip.notices)


def test_nameless_parameters_do_not_end_the_others() -> None:
    """They are records of blanks, which have no name in another file."""
    data = trial(**{"SUBJECTS__ ": (2, (), [1]), "MODEL__NAME": texts("walker")})
    said = read_statements(io.BytesIO(convert(data)[0]), [])
    assert said.texts("MODEL:NAME") == [b"walker"]


@pytest.mark.parametrize(("rate", "samples", "values"), [(2e38, 2, 2), (100.0, 1, 70_000), (100.0, 70, 70_000)])
def test_counts_that_words_and_floats_cannot_hold(rate: float, samples: int, values: int) -> None:
    count = values // samples
    said: dict[str, Value | None] = {"ANALOG:USED": (4, (), [count]), "ANALOG:RATE": (4, (), [rate])}
    header = {3: 0, 10: samples}
    data = c3d_bytes(
        np.ones((3, 1, 3)), analog=np.ones((3, values)), samples=samples, rate=rate, header=header, parameters=said
    )
    content, told = convert(data)
    assert len(read(C3D, {"c3d": content}).head.skeleton) == 1
    assert len(channels_of(content)) == (0 if values > 65_535 else count)
    assert any("left out" in words for words in told) == (values > 65_535)


@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_damaged_parameters_are_refused_or_written(data: st.DataObject) -> None:
    content = bytearray(trial())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(2, 2300))
        content[place] = data.draw(st.integers(0, 255))
    with suppress(McmlError):
        written, _ = convert(bytes(content))
        assert read(C3D, {"c3d": written}).frames
        channels_of(written).read()


def test_memory_does_not_grow_with_analog_samples() -> None:
    frames, values = 3000, 4000
    raw = np.zeros((1, values))
    data = c3d_bytes(np.ones((1, 1, 3)), analog=raw, samples=1, header={5: frames})
    row = 4 * (4 + values)
    start = 512 * (data[16] - 1)
    data = data[:start] + data[start : start + row] * frames
    clip = read(C3D, {"c3d": data})
    clip.original = kept_c3d(data)
    tracemalloc.start()
    try:
        size = sum(map(len, C3D.write(clip, "c3d")))
        assert size > 4 * frames * values
        assert tracemalloc.get_traced_memory()[1] < size
    finally:
        tracemalloc.stop()


@pytest.mark.slow
def test_real_files_after_a_trim(shared: Path, tmp_path: Path) -> None:
    compared = of_plates = by_ezc3d = 0
    for path in sorted([*shared.glob("c3d/*/*.[cC]3[dD]"), *shared.glob("lab/*.c3d")]):
        data = path.read_bytes()
        if path.name in ("bad_parameter_section.c3d", "Empty.c3d"):
            continue
        before = channels_of(data)
        first, last = before.frames // 4, before.frames // 2
        content, _ = convert(data, frames=f"{first + 1}-{last + 1}")
        after, count = channels_of(content), last - first + 1
        assert (after.frames, len(after)) == (count, len(before)), path.name
        if not len(before):
            continue
        compared += 1
        assert after.first == before.first + first, path.name
        assert (after.labels, after.units, after.rate) == (before.labels, before.units, before.rate), path.name
        assert after.read().tobytes() == before.read(first, count).tobytes(), path.name
        for own, new in zip(plates_of(before), plates_of(after), strict=True):
            # Of the same frames: the sign of a plate is decided by its largest force.
            samples = before.read(first, count, own.channels)
            expected = plate_forces(own, samples, before.rate)
            found = plate_forces(new, after.read(channels=new.channels), after.rate)
            assert found.force.tobytes() == expected.force.tobytes(), path.name
            assert found.centre_of_pressure.tobytes() == expected.centre_of_pressure.tobytes(), path.name
            of_plates += 1
        if path.name not in READ_OTHERWISE_BY_EZC3D:
            target = tmp_path / "again.c3d"
            target.write_bytes(content)
            wide = slice(first * before.samples, (first + count) * before.samples)
            expected_values = ezc3d.c3d(str(path))["data"]["analogs"][0][:, wide]
            assert np.array_equal(ezc3d.c3d(str(target))["data"]["analogs"][0], expected_values), path.name
            by_ezc3d += 1
    assert (compared > 10, of_plates > 20, by_ezc3d > 10) == (True, True, True)
