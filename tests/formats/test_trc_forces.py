"""Forces of the ground in a table beside a TRC: measured, written again, and left out with the reason."""

from __future__ import annotations

import io
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mcml
from mcml.errors import FormatError
from mcml.formats.c3d.parameters import read_statements
from mcml.formats.trc.force_table import FramesOfTrial, align, has_forces, read_table
from mcml.laboratory.gait_events import SIDES
from mcml.motion.skeleton import Array
from tests.force_trials import AXES, UNITS, Trial, make_trial
from tests.laboratory.walkers import SAMPLES, Gait, make_c3d, make_walker, true_events


def columns_of(motion: mcml.Motion, function: str, plate: int) -> Array:
    return np.stack([getattr(motion, function)(plate, axis) for axis in AXES], axis=1)


@settings(deadline=None, max_examples=25)
@given(
    seed=st.integers(0, 1000),
    up=st.integers(0, 2),
    samples=st.integers(1, 10),
    first=st.integers(0, 500),
    start=st.sampled_from([0.0, 0.23, 12.5]),
    unit=st.sampled_from(list(UNITS)),
)
def test_forces_are_those_of_the_table(
    tmp_path_factory: pytest.TempPathFactory, seed: int, up: int, samples: int, first: int, start: float, unit: str
) -> None:
    trial = make_trial(seed, up=up, samples=samples, first=first, start=start, unit=unit)
    motion = mcml.read(trial.write(tmp_path_factory.mktemp("trial")))
    force, moment = trial.means(trial.force), trial.means(np.cross(trial.point, trial.force) + trial.torque)
    for plate in range(2):
        assert np.allclose(columns_of(motion, "force", plate + 1), force[:, plate], rtol=1e-12)
        cop = columns_of(motion, "cop", plate + 1)
        # The wrench of the mean force at the centre of pressure, with the free moment, is the mean wrench.
        free = np.zeros_like(cop)
        free[:, up] = motion.free_moment(plate + 1)
        assert np.allclose(np.cross(cop, force[:, plate]) + free, moment[:, plate], atol=1e-8)
        assert np.allclose(cop[:, up], 0.03, atol=1e-7)
    assert next(item.notes for item in motion.measurements if item.function == "force")


def test_a_point_of_one_sample_is_the_centre_of_pressure(tmp_path: Path) -> None:
    trial = make_trial(3, samples=1)
    motion = mcml.read(trial.write(tmp_path))
    for plate in range(2):
        assert np.allclose(columns_of(motion, "cop", plate + 1), trial.point[:, plate], atol=1e-9)
        assert np.allclose(motion.free_moment(plate + 1), trial.torque[:, plate, 1], atol=1e-9)


@pytest.mark.parametrize(
    "names",
    [
        ("ground_force_{}_v", "ground_force_{}_p", "ground_moment_{}_m"),
        ("ground_force_{}_v", "ground_force_{}_p", "ground_torque_{}_"),
        ("R{}_ground_force_v", "R{}_ground_force_p", "R{}_ground_torque_"),
        ("foot{}_force_v", "foot{}_force_p", "foot{}_torque_"),
        ("FP{}_v", "FP{}_p", "FP{}_t"),
        ("f{}_", "p{}_", "m{}_"),
    ],
)
def test_columns_are_known_by_many_names(tmp_path: Path, names: tuple[str, str, str]) -> None:
    trial = make_trial(5)
    motion = mcml.read(trial.write(tmp_path, names))
    for plate in range(2):
        assert np.allclose(columns_of(motion, "force", plate + 1), trial.means(trial.force)[:, plate], rtol=1e-12)


@pytest.mark.parametrize(
    "names",
    [
        "time pelvis_tx pelvis_ty pelvis_tz hip_flexion_r",
        "time ground_force_vx ground_force_vy ground_force_vz",
        "time center_of_mass_X center_of_mass_Y center_of_mass_Z",
        "ground_force_vx",
        "",
    ],
)
def test_other_tables_have_no_forces(names: str) -> None:
    assert not has_forces(f"x\nversion=1\nendheader\n{names}\n0 1 2 3\n".encode())


def test_other_columns_are_analog_channels(tmp_path: Path) -> None:
    trial = make_trial(7)
    trc, mot = trial.write(tmp_path)
    lines = mot.read_text().split("\n")
    at = lines.index("endheader") + 1
    lines[at] += "\tEMG1"
    lines[at + 1 : -1] = [f"{row}\t{place}" for place, row in enumerate(lines[at + 1 : -1])]
    mot.write_text("\n".join(lines))
    motion = mcml.read([trc, mot])
    assert np.allclose(motion.analog("EMG1"), np.arange(12) * 4 + 1.5)
    assert np.allclose(motion.analog("Fz2"), trial.means(trial.force)[:, 1, 1])


def test_samples_between_rows_are_interpolated_and_told(tmp_path: Path) -> None:
    seconds = np.arange(0, 0.13, 1 / 250)
    line = 300 + 1000 * seconds
    force = np.zeros((len(seconds), 1, 3))
    force[:, 0, 1] = line
    still = np.zeros_like(force)
    other = Trial(seconds, force, still, still, 100.0, 2, 1, 12, "mm")
    motion = mcml.read(other.write(tmp_path))
    # 2.5 rows a frame: two samples, at the frame and half a frame later.
    assert np.allclose(motion.force(1, "y")[:-1], 300 + 1000 * (np.arange(11) / 100 + 0.0025))
    assert any("between the rows" in str(notice) for notice in motion.notices)


def test_frames_outside_the_table_are_unknown(tmp_path: Path) -> None:
    trial = make_trial(11)
    trc, mot = trial.write(tmp_path)
    lines = mot.read_text().split("\n")
    mot.write_text("\n".join(lines[: 7 + 4 * 9 + 1]) + "\n")
    motion = mcml.read([trc, mot])
    assert np.isfinite(motion.force(1, "y")).tolist() == [True] * 9 + [False] * 3
    assert any("forces are unknown in 3 of 12 frames" in str(notice) for notice in motion.notices)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda text: text.replace("0.0025", "0.0021", 1), "not even"),
        (lambda text: text.replace("0.0025", "-1", 1), "do not rise"),
        (lambda text: text.rsplit("\t", 1)[0] + "\n", "no whole rows"),
        (lambda text: text.replace("0.0025", "soon", 1), "'soon' is no number"),
    ],
)
def test_a_damaged_table_harms_only_itself(tmp_path: Path, change, reason: str) -> None:
    trc, mot = make_trial(13).write(tmp_path)
    mot.write_text(change(mot.read_text()))
    motion = mcml.read([trc, mot])
    assert len(motion) == 12
    assert not motion.measurements
    assert any(reason in str(notice) for notice in motion.notices)


def test_points_in_another_unit_are_not_used(tmp_path: Path) -> None:
    trial = make_trial(15)
    far = Trial(trial.times, trial.force, trial.point * 1000, trial.torque, 100.0, 4, 1, 12, "mm")
    motion = mcml.read(far.write(tmp_path))
    assert not motion.measurements
    assert any("metres are expected" in str(notice) for notice in motion.notices)


def test_a_plate_that_is_never_loaded_is_left_out(tmp_path: Path) -> None:
    trial = make_trial(17)
    trial.force[:, 0] = 0
    motion = mcml.read(trial.write(tmp_path))
    assert np.allclose(motion.force(1, "y"), trial.means(trial.force)[:, 1, 1])
    assert any("1_ground_force_v never reaches 20 N" in str(notice) for notice in motion.notices)


def test_a_c3d_has_the_forces_in_other_programs(tmp_path: Path) -> None:
    trial = make_trial(19, unit="mm")
    (path,) = mcml.convert(trial.write(tmp_path), tmp_path / "walk.c3d")
    other = ezc3d.c3d(str(path), extract_forceplat_data=True)
    for plate, read in enumerate(other["data"]["platform"]):
        assert np.allclose(np.abs(read["force"].T), np.abs(trial.force[:, plate]), rtol=1e-5, atol=1e-3)
        level = [0, 2]
        assert np.allclose(read["center_of_pressure"].T[:, level] / 1000, trial.point[:, plate][:, level], atol=1e-5)
    assert read_statements(io.BytesIO(path.read_bytes()), []).number("FORCE_PLATFORM:USED") == 2


@pytest.mark.parametrize("text", ["", "1 0", "a 0 100 12 mm", "1 0 0 12 mm", "1 nan 100 12 mm", "1 0 100 0"])
def test_a_section_of_other_programs_is_refused(text: str) -> None:
    with pytest.raises(FormatError, match="does not say which frames have forces"):
        FramesOfTrial.of(text)


def test_forces_of_another_time_are_refused() -> None:
    frames = FramesOfTrial(1, 100.0, 100.0, 10, "mm")
    with pytest.raises(FormatError, match=r"forces are from 0 s to 0\.9 s, frames from 100 s"):
        align(np.arange(10) / 10, frames)
    with pytest.raises(FormatError, match="no row of names"):
        read_table(io.BytesIO(b"no table"))


@settings(deadline=None, max_examples=150)
@given(cut=st.floats(0, 1), flips=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 255)), max_size=4))
def test_damaged_bytes_are_told_and_leave_the_markers(
    tmp_path_factory: pytest.TempPathFactory, cut: float, flips: list[tuple[float, int]]
) -> None:
    trc, mot = make_trial(21).write(tmp_path_factory.mktemp("damaged"))
    data = bytearray(mot.read_bytes())
    for place, value in flips:
        data[int(place * (len(data) - 1))] = value
    mot.write_bytes(bytes(data[: int(cut * len(data))]))
    try:
        motion = mcml.read([trc, mot])
    except mcml.Error:
        # Without its head it is no table of forces.
        return
    assert len(motion) == 12
    assert any("force" in str(notice) for notice in motion.notices)
    for item in motion.measurements:
        if item.function == "force" and item.known and item.name.isdigit():
            assert columns_of(motion, "force", int(item.name)).shape == (12, 3)


def write_feet(gait: Gait, folder: Path) -> list[Path]:
    """The markers of a walker as TRC, and all steps of each foot in columns of its own."""
    (folder / "walk.c3d").write_bytes(make_c3d(gait))
    (trc,) = mcml.convert(folder / "walk.c3d", folder / "walk.trc")
    walker, rate = make_walker(gait), gait.rate * SAMPLES
    frames = np.arange(len(walker)) / gait.rate
    times = np.arange(len(walker) * SAMPLES) / rate
    columns, names = [times], ["time"]
    for side, letter in zip(SIDES, "LR", strict=True):
        force, point = np.zeros((len(times), 3)), np.zeros((len(times), 3))
        ends = (walker.heels[side], walker.toes[side])
        heel, toe = (np.stack([np.interp(times, frames, axis) for axis in end.T], axis=1) for end in ends)
        for strike in true_events(gait)[side, "strike"]:
            share = (times - strike) / (gait.duty * gait.stride_time)
            down = (share > 0) & (share < 1)
            force[down] = 800 * np.sin(np.pi * share[down])[:, None] * walker.up
            point[down] = (heel + share[:, None] * (toe - heel))[down]
        point -= np.outer(point @ walker.up, walker.up)
        for name, part in (("force_v", force), ("force_p", point), ("torque_", 0 * force)):
            names += [f"{letter}_ground_{name}{axis}" for axis in AXES]
            columns += list(part.T)
    rows = ["\t".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()]
    head = ["walk", "version=1", f"nRows={len(rows)}", f"nColumns={len(names)}", "inDegrees=yes", "endheader"]
    (folder / "walk.mot").write_text("\n".join([*head, "\t".join(names), *rows]) + "\n")
    return [trc, folder / "walk.mot"]


@pytest.mark.parametrize("on_belt", [False, True])
def test_all_steps_in_the_columns_of_a_foot_have_events(tmp_path: Path, on_belt: bool) -> None:
    gait = Gait(seconds=6, on_belt=on_belt, up="Y", heading=20)
    motion = mcml.read(write_feet(gait, tmp_path))
    found = [event for event in motion.measure_gait().events if event.source == "plate"]
    assert len(found) >= 18
    for event in found:
        assert min(abs(at - event.seconds) for at in true_events(gait)[event.side, event.kind]) < 0.01, event
    for side in SIDES:
        assert np.nanmax(motion.force(side, "y")) > 700


def test_points_tell_the_foot_and_names_do_not(tmp_path: Path) -> None:
    paths = write_feet(Gait(seconds=4, up="Y"), tmp_path)
    plain = mcml.read(paths)
    text = paths[1].read_text()
    paths[1].write_text(text.replace("L_ground", "X_ground").replace("R_ground", "L_ground").replace("X_", "R_"))
    swapped = mcml.read(paths)
    for side in SIDES:
        np.testing.assert_array_equal(swapped.force(side, "y"), plain.force(side, "y"))
