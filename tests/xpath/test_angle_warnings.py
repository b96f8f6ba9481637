"""Answers tell of angles as with a goniometer, and of clinical angles whose sign or zero is unknown."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mcml_schemas.querying.queries import QueryRequest
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import one_kind, store
from tests.motion.bodies.rig import random_angles, turns_of, write_rig

pytestmark = one_kind
KEY_POINTS = ("LHip", "RHip", "LKnee", "RKnee", "LAnkle", "RAnkle", "LBigToe", "RBigToe", "Neck", "MidHip")


def key_points() -> bytes:
    """Centres of joints alone, as cameras find them."""
    rng = np.random.default_rng(2)
    head = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate"
    head += f"\tOrigDataStartFrame\tOrigNumFrames\n100\t100\t5\t{len(KEY_POINTS)}\tm\t100\t1\t5\n"
    names = "Frame#\tTime\t" + "\t\t\t".join(KEY_POINTS) + "\t\t\n"
    axes = "\t\t" + "\t".join(f"{axis}{n + 1}" for n in range(len(KEY_POINTS)) for axis in "XYZ") + "\n\n"
    rows = [
        f"{row + 1}\t{row / 100}\t" + "\t".join(f"{value:.4f}" for value in rng.uniform(0, 1, 3 * len(KEY_POINTS)))
        for row in range(5)
    ]
    return (head + names + axes + "\n".join(rows) + "\n").encode()


@pytest.fixture
def engine(database: Database) -> Iterator[Queries]:
    upright = {name: Rotation.from_euler("x", 170, degrees=True) for name in ("left_up_leg", "right_up_leg")}
    turns = turns_of(random_angles(np.random.default_rng(1), 20, hinge=True), Rotation.identity(20))
    store(
        database, {"stands.bvh": write_rig(turns), "folded.bvh": write_rig(turns, upright), "points.trc": key_points()}
    )
    engine = Queries(database, Settings(cache_dir="none"))
    yield engine
    engine.close()


def warnings(engine: Queries, angle: str) -> list[str]:
    return engine.answer(QueryRequest(q=f"//frame[mo:angle('{angle}') > 10]")).warnings


def test_old_names_name_the_clinical_angle(engine: Queries) -> None:
    for old, new in (("left-leg-flexion", "left-hip-flexion"), ("pelvis-anterior-tilt", "pelvis-tilt")):
        (found,) = [each for each in warnings(engine, old) if "goniometer" in each]
        assert found.startswith(f"{old} is measured as with a goniometer; {new} is the clinical angle")
    for name in ("left-hip-flexion", "left-arm-flexion", "left-leg-horizontal-abduction"):
        assert not any("goniometer" in each for each in warnings(engine, name))


def test_knees_without_a_sign_are_counted(engine: Queries) -> None:
    (found,) = [each for each in warnings(engine, "left-knee-flexion") if "sign" in each]
    assert found.startswith("1 of 3 documents have left-knee-flexion without its sign")
    assert "('points')" in found
    (found,) = [each for each in warnings(engine, "right-hip-internal-rotation") if "no value" in each]
    assert found.startswith("1 of 3 documents have no value: no rotation or marker tells where the left of")


def test_angles_in_the_frame_of_joints_are_counted(engine: Queries) -> None:
    for name in ("left-hip-flexion", "pelvis-tilt"):
        (found,) = [each for each in warnings(engine, name) if "frame of their joints" in each]
        assert found.startswith(f"2 of 3 documents have {name} in the frame")
        assert "'folded', 'points'" in found
    # The points have no toes.
    (found,) = [each for each in warnings(engine, "right-ankle-dorsiflexion") if "frame of their joints" in each]
    assert found.startswith("1 of 3 documents have right-ankle-dorsiflexion")
    assert not any("of their joints" in each for each in warnings(engine, "left-hip-adduction"))
