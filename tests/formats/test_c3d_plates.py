"""C3D: the group FORCE_PLATFORM as plates, and the forces of real files by another reader."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcml.errors import McmlError
from mcml.formats import FORMATS
from mcml.formats.c3d.analog import read_channels
from mcml.formats.c3d.plates import plates_of, read_plates
from mcml.formats.format import ReadOptions
from mcml.formats.measurements import Measurements
from mcml.laboratory.force_plates import Plate, plate_forces
from mcml.motion.floor_plates import kept_plates
from mcml.testing import read
from tests.c3d_writer import Value, c3d_bytes, kept_c3d, texts

CORNERS = [[500.0, 300, 0], [500, -300, 0], [-500, -300, 0], [-500, 300, 0]]
"""x of the plate is y of the laboratory, y is x, z is down."""
LOAD = [-40.0, 80, -700, -140_000, 70_000, 11_000]
"""N and N mm about the centre: in the laboratory the force (80, -40, 700) at x = 200, y = 100 mm, 5 N m about up."""
ORDER = [1, 2, 3, 4, 5, 6]


def file_of(types: list[int], channels: list[int], rows: np.ndarray | None = None, **said: Value | None) -> bytes:
    """A file of plates at one place. rows: (n, channels) of two frames. said: other parameters than usual."""
    count = len(types)
    rows = np.tile(LOAD, (2, 2)) if rows is None else rows
    parameters: dict[str, Value | None] = {
        "FORCE_PLATFORM:USED": (2, (), [count]),
        "FORCE_PLATFORM:TYPE": (2, (count,), types),
        "FORCE_PLATFORM:CORNERS": (4, (3, 4, count), np.tile(np.ravel(CORNERS), count).tolist()),
        "FORCE_PLATFORM:ORIGIN": (4, (3, count), [0.0] * (3 * count)),
        "FORCE_PLATFORM:CHANNEL": (2, (len(channels) // count, count), channels),
        "ANALOG:UNITS": texts(*["N", "N", "N", "Nmm", "Nmm", "Nmm"] * 2),
        "ANALOG:SCALE": (4, (rows.shape[1],), [1.0] * rows.shape[1]),
        "ANALOG:OFFSET": (2, (rows.shape[1],), [0] * rows.shape[1]),
    }
    parameters |= {name.replace("__", ":"): value for name, value in said.items()}
    return c3d_bytes(np.ones((len(rows), 1, 3)), analog=rows, parameters=parameters)


def check_load(plate: Plate, rows: np.ndarray) -> None:
    found = plate_forces(plate, rows[:, plate.channels])
    assert not found.problems
    assert np.allclose(found.force, [80, -40, 700])
    assert np.allclose(found.centre_of_pressure, [0.2, 0.1, 0.0])
    assert np.allclose(found.free_moment, 5.0)


def plates_in(data: bytes) -> list[Plate]:
    return read_plates(io.BytesIO(data))


def problems_of(data: bytes) -> list[tuple[str, ...]]:
    channels = read_channels(io.BytesIO(data))
    return [plate_forces(plate, channels.read(channels=plate.channels)).problems for plate in plates_of(channels)]


def test_plates_of_a_file() -> None:
    rows, units = np.tile([*LOAD, *LOAD[::-1]], (2, 1)), ["N", "N", "N", "Nmm", "Nmm", "Nmm"]
    data = file_of([2, 2], [*ORDER, 12, 11, 10, 9, 8, 7], rows, ANALOG__UNITS=texts(*units, *units[::-1]))
    channels = read_channels(io.BytesIO(data))
    plates = plates_of(channels)
    assert [plate.channels for plate in plates] == [(0, 1, 2, 3, 4, 5), (11, 10, 9, 8, 7, 6)]
    for plate in plates:
        assert not plate.assumptions
        assert np.allclose(plate.corners, np.array(CORNERS) / 1000)
        check_load(plate, channels.read())


@pytest.mark.parametrize(
    ("unit", "points", "size", "moments", "assumed"),
    [
        ("Nmm", "mm", 1.0, 1.0, []),
        ("N.m", "mm", 1.0, 0.001, []),
        ("ntmm", "mm", 1.0, 1.0, []),
        ("Nm", "m", 0.001, 0.001, []),
        ("V", "m", 0.001, 0.001, ["its moments are taken as N m: the channels have the unit 'V'"]),
        ("", "mm", 1.0, 1.0, ["its moments are taken as N mm: the channels have no unit"]),
        ("Nmm", "", 1.0, 1.0, ["lengths are taken as mm: the file states no unit"]),
        ("Nmm", "rods", 1.0, 1.0, ["lengths are taken as mm: the file has the unknown unit 'rods'"]),
    ],
)
def test_units(unit: str, points: str, size: float, moments: float, assumed: list[str]) -> None:
    rows = np.tile(LOAD * np.array([1, 1, 1, moments, moments, moments]), (2, 2))
    corners: Value = (4, (3, 4, 1), (np.ravel(CORNERS) * size).tolist())
    data = file_of(
        [2],
        ORDER,
        rows,
        FORCE_PLATFORM__CORNERS=corners,
        ANALOG__UNITS=texts(*["N", "N", "N", unit, unit, unit] * 2),
        POINT__UNITS=texts(points) if points else None,
    )
    (plate,) = plates_in(data)
    check_load(plate, rows)
    assert list(plate.assumptions) == assumed


def test_forces_of_unknown_units_are_told() -> None:
    (plate,) = plates_in(file_of([2], ORDER, ANALOG__UNITS=None))
    assert plate.assumptions == (
        "its forces are taken as N: the channels have no unit",
        "its moments are taken as N mm: the channels have no unit",
    )
    (plate,) = plates_in(file_of([2], ORDER, ANALOG__UNITS=texts(*["lb", "kN", "N", "in-lb", "ft.lb", "Ncm"])))
    pound = 4.4482216152605
    assert plate.factors == pytest.approx((pound, 1000, 1, 0.0254 * pound, 0.3048 * pound, 0.01))


def test_places_of_type_1_are_lengths() -> None:
    rows = np.tile([-40.0, 80, -700, 0.1, 200, -5000] * 2, (2, 1))
    (plate,) = plates_in(file_of([1], ORDER, rows, ANALOG__UNITS=texts("N", "N", "N", "m", "mm", "Nmm")))
    check_load(plate, rows)


def test_calibration_is_by_columns() -> None:
    matrix = np.diag([10.0, 20, 30, 400, 500, 600])
    matrix[0, 4] = 3.0  # The force along x takes up the fifth channel.
    rows = np.tile(np.linalg.solve(matrix, LOAD), (2, 2))
    volts = texts(*["V"] * 12)
    columns: Value = (4, (6, 6, 1), matrix.T.ravel().tolist())
    data = file_of([4], ORDER, rows, ANALOG__UNITS=volts, FORCE_PLATFORM__CAL_MATRIX=columns)
    channels = read_channels(io.BytesIO(data))
    (plate,) = plates_of(channels)
    assert np.allclose(plate_forces(plate, rows[:, plate.channels]).force, [80, -40, 700])
    check_load(plate, rows)
    assert problems_of(file_of([4], ORDER)) == [("type 4 needs a calibration matrix, and it has none",)]
    # The file has a matrix for the first plate alone.
    data = file_of([4, 4], [*ORDER, *ORDER], rows, FORCE_PLATFORM__CAL_MATRIX=columns)
    assert [bool(problems) for problems in problems_of(data)] == [False, True]


def test_plates_that_cannot_be_used_say_why() -> None:
    data = file_of([2, 6], [*ORDER, *ORDER])
    assert problems_of(data) == [(), ("force plate type 6 is not read",)]
    assert problems_of(file_of([2, 2], [*ORDER, *range(9, 15)])) == [
        (),
        ("its channels 13, 14 are not in the file, which has 12",),
    ]
    assert problems_of(file_of([2], [1, 2, 3, 0, 0, 0]))[0] == (
        "its channels 0, 0, 0 are not in the file, which has 12",
    )
    assert problems_of(file_of([2], [1, 2, 3])) == [("the file names 3 of its 6 channels",)]
    assert problems_of(file_of([2], ORDER, FORCE_PLATFORM__CHANNEL=None)) == [("the file names 0 of its 6 channels",)]
    assert problems_of(file_of([3], ORDER)) == [("the file names 6 of its 8 channels",)]
    assert problems_of(file_of([2], ORDER, FORCE_PLATFORM__CORNERS=None)) == [("its corners are unknown",)]
    corners: Value = (4, (3, 4, 1), [0.0] * 12)
    assert problems_of(file_of([2], ORDER, FORCE_PLATFORM__CORNERS=corners)) == [("its corners enclose no area",)]
    assert problems_of(file_of([2], ORDER, FORCE_PLATFORM__ORIGIN=None)) == [("its origin is unknown",)]
    assert problems_of(file_of([2], ORDER, FORCE_PLATFORM__TYPE=None)) == [("the file does not state its type",)]


def test_more_plates_than_used() -> None:
    data = file_of([2, 2], [*ORDER, *range(7, 13)], FORCE_PLATFORM__USED=(2, (), [1]))
    (plate,) = plates_in(data)
    assert plate.channels == (0, 1, 2, 3, 4, 5)
    assert plates_in(file_of([2], ORDER, FORCE_PLATFORM__USED=(2, (), [0]))) == []
    assert len(plates_in(file_of([2, 2], [*ORDER, *ORDER], FORCE_PLATFORM__USED=None))) == 2
    assert plates_in(c3d_bytes(np.ones((2, 1, 3)))) == []


def test_plates_of_types_with_other_counts_of_channels() -> None:
    """Eight rows of channels for all, as one plate is of type 3."""
    data = file_of([2, 3], [*ORDER, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8])
    assert [plate.channels for plate in plates_in(data)] == [tuple(range(6)), tuple(range(8))]


NUMBERS = st.lists(st.floats(width=32), max_size=80)


@pytest.mark.slow
@given(
    used=st.floats(width=32),
    types=st.lists(st.one_of(st.integers(0, 9).map(float), st.floats(width=32)), max_size=9),
    channels=NUMBERS,
    corners=NUMBERS,
    origin=NUMBERS,
    matrix=NUMBERS,
)
@settings(max_examples=100, deadline=None)
def test_no_numbers_of_plates_are_an_exception(
    used: float,
    types: list[float],
    channels: list[float],
    corners: list[float],
    origin: list[float],
    matrix: list[float],
) -> None:
    lists = {"TYPE": types, "CHANNEL": channels, "CORNERS": corners, "ORIGIN": origin, "CAL_MATRIX": matrix}
    said = {f"FORCE_PLATFORM__{name}": (4, (len(numbers),), numbers) for name, numbers in lists.items()}
    try:
        problems_of(file_of([2], ORDER, **said, FORCE_PLATFORM__USED=(4, (), [used])))
    except McmlError as error:
        pytest.fail(str(error))


def test_real_files(shared: Path) -> None:
    """expected.json has three digits behind the point."""
    expected = json.loads((shared / "lab/expected.json").read_text())
    compared = 0
    for name in (name for name in expected if name.endswith(".c3d") and expected[name].get("plates")):
        with (shared / "lab" / name).open("rb") as stream:
            channels = read_channels(stream)
            plates = plates_of(channels)
            for plate, facts in zip(plates, expected[name]["plates"], strict=True):
                found = plate_forces(plate, channels.read(channels=plate.channels), channels.rate)
                at = facts["at_sample"]
                assert (plate.type, len(found.force), found.problems) == (facts["type"], facts["samples"], ()), name
                assert np.allclose(plate.corners * 1000, facts["corners"], rtol=0, atol=0.00501), name
                assert np.allclose(found.force[at], facts["force_N"], rtol=0, atol=0.000501), name
                pressure, free = (np.array(facts[key], dtype=float) for key in ("cop", "Tz"))
                assert np.allclose(found.centre_of_pressure[at] * 1000, pressure, rtol=0, atol=0.000501, equal_nan=True)
                assert np.isclose(
                    found.free_moment[at] * 1000, free @ found.vertical, rtol=0, atol=1e-3, equal_nan=True
                )
                assert not found.is_turned
                compared += 1
    assert compared > 20


@pytest.mark.slow
def test_real_files_as_ezc3d_computes_them(shared: Path) -> None:
    compared = 0
    for path in sorted(
        [*shared.glob("c3d/encodings/*.c3d"), *shared.glob("lab/*.c3d"), *shared.glob("c3d/edge/p*.c3d")]
    ):
        try:
            others = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"]
        except (RuntimeError, ValueError, OSError):
            continue
        with path.open("rb") as stream:
            channels = read_channels(stream)
            plates = plates_of(channels) if len(channels) else []
            for plate, other in zip(plates, others, strict=True):
                found = plate_forces(plate, channels.read(channels=plate.channels), channels.rate)
                sign = -1 if found.is_turned else 1
                assert np.abs(found.force - sign * other["force"].T).max() <= 1e-9 * np.abs(found.force).max(), (
                    path.name
                )
                loaded = np.isfinite(found.free_moment)
                pressure, free = other["center_of_pressure"].T[loaded], other["Tz"].T[loaded] @ found.vertical
                assert np.allclose(found.centre_of_pressure[loaded] * 1000, pressure, rtol=0, atol=1e-6), path.name
                assert np.allclose(found.free_moment[loaded] * 1000, sign * free, rtol=0, atol=1e-6), path.name
                compared += bool(loaded.any())
    assert compared > 20


@pytest.mark.parametrize(
    ("screen", "stated", "kind", "told"),
    [
        ("+Z", "Z", "guess", "Z counts as up: the file shows it upward on the screen (Y_SCREEN); the force plates"),
        ("+Y", None, "warning", "no up axis is stated: the file shows Y upward on the screen (Y_SCREEN), but Z is"),
        ("-Z", None, None, ""),
    ],
)
def test_the_axis_on_the_screen_may_contradict_plates(
    screen: str, stated: str | None, kind: str | None, told: str
) -> None:
    clip = read(FORMATS["c3d"], {"c3d": file_of([2], ORDER, POINT__Y_SCREEN=texts(screen))}, ReadOptions())
    assert clip.head.fields.get("global_axis_of_gravity") == stated
    notices = [(notice.kind, notice.what) for notice in clip.notices if "screen" in notice.what]
    assert [notice[0] for notice in notices] == ([] if kind is None else [kind])
    assert all(what.startswith(told) for _, what in notices)
    assert np.array_equal(kept_plates(clip.head), [CORNERS])


def test_plates_without_corners_are_not_kept() -> None:
    flat: Value = (4, (3, 4, 1), [0.0] * 12)
    for corners in (flat, None, (4, (3, 2, 1), [1.0] * 6)):
        data = file_of([2], ORDER, FORCE_PLATFORM__CORNERS=corners)
        assert not len(kept_plates(read(FORMATS["c3d"], {"c3d": data}, ReadOptions()).head))


OFFSET = [3.0, -2, 25, 500, -900, 70]


def rows_with_offset(load: list[float], frames: int = 12) -> np.ndarray:
    """(frames, 6) a load from the fifth frame on, with an offset throughout."""
    rows = np.tile(OFFSET, (frames, 1)).astype(np.float64)
    rows[4:] += load
    return rows


@pytest.mark.parametrize("baseline", [[1, 4], [2, 3], [4, 4]])
def test_the_baseline_of_the_file_is_subtracted_if_asked(baseline: list[int]) -> None:
    rows = rows_with_offset(LOAD)
    channels = read_channels(io.BytesIO(file_of([2], ORDER, rows, FORCE_PLATFORM__ZERO=(2, (2,), baseline))))
    (plain,), (corrected,) = plates_of(channels), plates_of(channels, subtract_baseline=True)
    check_load(corrected, rows[4:])
    assert np.allclose(plate_forces(corrected, rows).force[:4], 0)
    assert "is subtracted: 25.3 N" in corrected.assumptions[-1]
    assert plate_forces(plain, rows).force[0, 2] == pytest.approx(-25)
    assert "is not subtracted" in plain.assumptions[-1]


@pytest.mark.parametrize("baseline", [[0, 0], [1, 0], [0, 10], [5, 13], [-3, 4], [3, 2], [1]])
def test_ranges_that_are_no_frames_of_the_file_are_no_baseline(baseline: list[int]) -> None:
    zero = (2, (len(baseline),), baseline)
    channels = read_channels(io.BytesIO(file_of([2], ORDER, rows_with_offset(LOAD), FORCE_PLATFORM__ZERO=zero)))
    (plate,) = plates_of(channels, subtract_baseline=True)
    assert not plate.baseline
    assert not plate.assumptions


def test_a_person_on_the_plate_is_no_baseline() -> None:
    zero = (2, (2,), [5, 8])
    channels = read_channels(io.BytesIO(file_of([2], ORDER, rows_with_offset(LOAD), FORCE_PLATFORM__ZERO=zero)))
    (plate,) = plates_of(channels, subtract_baseline=True)
    assert not plate.baseline
    assert "has a load of 680 N" in plate.assumptions[-1]


@pytest.mark.parametrize(("properties", "offset"), [((("gait baseline", "Subtract", ""),), 0.0), ((), -25.0)])
def test_a_property_asks_for_the_baseline(properties: tuple[tuple[str, str, str], ...], offset: float) -> None:
    zero = (2, (2,), [1, 4])
    data = file_of([2], ORDER, rows_with_offset(LOAD), FORCE_PLATFORM__ZERO=zero)
    head = replace(read(FORMATS["c3d"], {"c3d": data}).head, properties=properties)
    measurements = Measurements(head, kept_c3d(data).read_channels)
    forces = measurements.plates_at(np.arange(1, 13))[1].force[:, 2]
    assert forces == pytest.approx([offset] * 4 + [700.0 + offset] * 8, abs=1e-3)
    note = next(each.notes[-1] for each in measurements.describe() if each.function == "force")
    assert ("is subtracted" in note) == bool(properties)
