"""One reference pose a skeleton: however a clip is cut, turned round or put together, a frame keeps its angles."""

from __future__ import annotations

import numpy as np
import pytest
from fastapi.testclient import TestClient
from scipy.spatial.transform import Rotation

from mcml.motion.bodies.quantities import compute
from mcml.motion.skeleton import Array
from mcml_service.clips.bodies import read_bodies, read_turned
from mcml_service.clips.derive import derive_missing
from mcml_service.storage.database import Database
from tests.builders import one_kind, store
from tests.motion.bodies.made import PARTS, person
from tests.motion.bodies.rig import random_angles, turns_of, write_rig

API = "/api/v1"
ANGLES = ("left-forearm-pronation", "head-flexion", "right-leg-medial-rotation", "left-wrist-flexion", "neck-flexion")
FRAMES = 60


def floating(seed: int, frames: int = FRAMES) -> bytes:
    """A person whose joints have no offsets at rest: where each is comes with the motion."""
    text = person(seed, frames).decode()
    head, _, tail = text.partition("MOTION")
    lines = []
    joints = []
    for line in head.splitlines():
        words = line.split()
        if words[:1] in (["ROOT"], ["JOINT"]):
            joints.append(words[1])
        if words[:1] == ["OFFSET"] and "\tEnd Site" not in "".join(lines[-2:]):
            line = line[: line.index("OFFSET")] + "OFFSET 0 0 0"
        if words[:1] == ["CHANNELS"]:
            line = line[: line.index("CHANNELS")] + "CHANNELS 6 Xposition Yposition Zposition " + " ".join(words[-3:])
        lines.append(line)
    count, time, *rows = tail.strip().splitlines()
    made = []
    for row in rows:
        values = row.split()
        turns = [values[3 + 3 * n : 6 + 3 * n] for n in range(len(joints))]
        places = [values[:3], *([f"{v}" for v in PARTS[name][1]] for name in joints[1:])]
        made.append(" ".join(word for place, turn in zip(places, turns, strict=True) for word in (*place, *turn)))
    return "\n".join([*lines, "MOTION", count, time, *made, ""]).encode()


def angles(database: Database, uuid: str) -> Array:
    """(frames, angles) of a document as it is now."""
    with database.read() as tx:
        (listed,) = [one for one in tx.columns.documents() if one.uuid == uuid]
        body = read_bodies(tx, [listed])[listed.key]
        return np.stack([read_turned(tx, listed, name, body) for name in ANGLES], axis=1)


def edited(client: TestClient, uuid: str, edit: dict[str, object]) -> None:
    answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": [edit]}, headers={"if-match": "*"})
    assert answer.status_code == 200, answer.text


@one_kind
@pytest.mark.parametrize("kept", [False, True])
def test_cuts_turns_and_compositions_keep_angles(database: Database, client: TestClient, kept: bool) -> None:
    (uuid,) = store(database, {"walk.bvh": floating(3)})
    (other,) = store(database, {"run.bvh": floating(5)})

    def derive() -> None:
        if kept:
            derive_missing(database, lambda done, of: None)

    derive()
    whole, others = angles(database, uuid), angles(database, other)
    assert np.isfinite(whole).all()
    assert np.ptp(whole, axis=0).min() > 5
    shown = client.get(f"{API}/documents/{other}/calibration").json()["reference"]
    assert "'walk'" in shown["reason"]
    segments = [{"document": other}, {"document": uuid, "first": 11, "last": 30}]
    made = client.post(f"{API}/compose", json={"name": "both", "segments": segments, "align": False}).json()
    derive()
    found = angles(database, made["document"])
    np.testing.assert_allclose(found[:FRAMES], others, atol=1e-4)
    np.testing.assert_allclose(found[-20:], whole[10:30], atol=1e-4)
    edited(client, uuid, {"do": "reverse", "first": 1, "last": FRAMES})
    derive()
    np.testing.assert_array_equal(angles(database, uuid), whole[::-1])
    edited(client, uuid, {"do": "keep", "first": 5, "last": 17})
    derive()
    np.testing.assert_array_equal(angles(database, uuid), whole[::-1][4:17])
    np.testing.assert_array_equal(angles(database, other), others)


@one_kind
def test_a_reference_that_is_set_keeps_its_pose(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"walk.bvh": floating(3)})
    place = f"{API}/documents/{uuid}/calibration"
    before = angles(database, uuid)
    client.patch(place, json={"reference": "31"}, headers={"if-match": "*"}).raise_for_status()
    whole = angles(database, uuid)
    np.testing.assert_allclose(whole[30], 0, atol=1e-3)
    edited(client, uuid, {"do": "keep", "first": 40, "last": 60})
    np.testing.assert_array_equal(angles(database, uuid), whole[39:])
    assert client.get(place).json()["reference"]["value"] == 31
    client.patch(place, json={"reference": None}, headers={"if-match": "*"}).raise_for_status()
    np.testing.assert_array_equal(angles(database, uuid), before[39:])


@one_kind
def test_a_part_of_a_clip_is_written_with_the_angles_that_it_has(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"walk.bvh": floating(3)})
    client.patch(
        f"{API}/documents/{uuid}", json={"up": "Y", "unit": "cm"}, headers={"if-match": "*"}
    ).raise_for_status()

    def written(**part: int) -> list[list[str]]:
        answer = client.get(f"{API}/documents/{uuid}/export", params={"format": "mot", **part})
        assert answer.status_code == 200, answer.text
        rows = answer.text.partition("endheader\n")[2].splitlines()
        columns = [rows[0].split().index(name) for name in ("head_flexion", "forearm_pronation_l")]
        return [[row.split()[column] for column in columns] for row in rows[1:]]

    assert written(first=21, last=30) == written()[20:30]


CLINICAL = ("left-knee-flexion", "right-knee-flexion", "left-hip-internal-rotation", "right-hip-internal-rotation")


def clinical(database: Database, uuid: str) -> Array:
    """(frames, clinical angles) of a document as it is now."""
    with database.read() as tx:
        (listed,) = [one for one in tx.columns.documents() if one.uuid == uuid]
        body = read_bodies(tx, [listed])[listed.key]
        stretch = body.stretch((*body.names, *body.lines))
        return np.stack([compute("angle", (name,), stretch) for name in CLINICAL], axis=1)


@one_kind
@pytest.mark.parametrize("kept", [False, True])
def test_all_clips_and_cuts_of_a_skeleton_share_the_axes_of_knees(
    database: Database, client: TestClient, kept: bool
) -> None:
    rest = {name: Rotation.from_euler("x", 170, degrees=True) for name in ("left_up_leg", "right_up_leg")}
    made = [random_angles(np.random.default_rng(seed), FRAMES, hinge=seed == 1) for seed in (1, 2)]
    # The second knee turns a little, so that its clip alone has another axis.
    made[1] |= {name: degrees * 0.1 for name, degrees in made[1].items() if "knee-v" in name or "knee-i" in name}
    made[1] |= {name: degrees + 3.0 for name, degrees in made[1].items() if "knee-varus" in name}
    clips = {f"{n}.bvh": write_rig(turns_of(angles, Rotation.identity(FRAMES)), rest) for n, angles in enumerate(made)}
    one, other = store(database, clips)

    def derive() -> None:
        if kept:
            derive_missing(database, lambda done, of: None)

    derive()
    whole, others = clinical(database, one), clinical(database, other)
    with database.read() as tx:
        bodies = read_bodies(tx, list(tx.columns.documents())).values()
    first, second = (body.calibration for body in bodies)
    assert first.bones == second.bones
    assert {axis.origin for axis in first.bones.values()} == {"hinge"}
    # Pooled over both clips.
    assert 0.1 < min(hinge[3] for hinge in first.start.hinges.values()) < 6
    edited(client, other, {"do": "keep", "first": 11, "last": 30})
    edited(client, one, {"do": "keep", "first": 41, "last": 60})
    derive()
    np.testing.assert_array_equal(clinical(database, other), others[10:30])
    np.testing.assert_array_equal(clinical(database, one), whole[40:])
