"""What viewers ask for: skeletons, and blocks of positions that are addressed by revision."""

from __future__ import annotations

import io
from urllib.parse import unquote

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.motion.skeleton import Array
from mcml_service.storage.database import Database
from tests.actions.test_measurements import walkway
from tests.builders import ASF as LEG
from tests.builders import HTR, TRC, amc, bvh, one_kind, store, upload

pytestmark = one_kind
API = "/api/v1/documents"
LASTING = "private, max-age=31536000, immutable"


def stored(client: TestClient, files: dict[str, bytes], **form: object) -> str:
    return str(upload(client, files, **form)["documents"][0]["id"])  # type: ignore[index]


def positions(client: TestClient, uuid: str, **more: object) -> Array:
    asked = {"space": "positions", "format": "npy", **more}
    found: Array = np.load(io.BytesIO(client.get(f"{API}/{uuid}/frames", params=asked).content))
    return found


def test_a_skeleton_has_all_that_a_viewer_needs(client: TestClient) -> None:
    names = ("Hips", "LeftUpLeg", "RightUpLeg")
    uuid = stored(client, {"walk.bvh": bvh(5, names=names)})
    found = client.get(f"{API}/{uuid}/skeleton").json()
    assert (found["bones"][0]["name"], found["bones"][0]["parent"]) == ("Hips", -1)
    assert [bone["side"] for bone in found["bones"]] == ["centre", "centre", "centre"], "one hangs on the other"
    assert found["bones"][1]["offset"] == [0.0, 10.5, 0.0]
    assert found["bones"][0]["channels"] == ["Tx", "Ty", "Tz", "Rz", "Rx", "Ry"]
    assert found["tips"] == [{"bone": 2, "name": "", "offset": [0.0, 5.25, 0.0]}]
    assert (found["frames"], found["frame_time"], found["seconds_per_frame"]) == (5, "0.0083333", 0.0083333)
    assert (found["unit"], found["up"], found["likely_up"], found["markers"]) == (None, None, found["likely_up"], False)
    assert found["origin"] == positions(client, uuid)[0, 0].tolist(), "exactly"


TWO_LEGS = b"""HIERARCHY
ROOT Hips
{
 OFFSET 0 0 0
 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
 JOINT LeftUpLeg
 {
  OFFSET 9.1 -2 0
  CHANNELS 3 Zrotation Xrotation Yrotation
  End Site
  {
   OFFSET 0 -80 0
  }
 }
 JOINT RightUpLeg
 {
  OFFSET -9.1 -2 0
  CHANNELS 3 Zrotation Xrotation Yrotation
  End Site
  {
   OFFSET 0 -80 0
  }
 }
 JOINT Head
 {
  OFFSET 0 0 71.3
  CHANNELS 3 Zrotation Xrotation Yrotation
  End Site
  {
   OFFSET 0 0 12
  }
 }
}
MOTION
Frames: 1
Frame Time: 0.01
5 6 7 0 0 0 0 0 0 0 0 0 0 0 0
"""


def test_sides_partners_and_the_likely_axis(client: TestClient) -> None:
    found = client.get(f"{API}/{stored(client, {'a.bvh': TWO_LEGS})}/skeleton").json()
    assert [bone["side"] for bone in found["bones"]] == ["centre", "left", "right", "centre"]
    assert [bone["partner"] for bone in found["bones"]] == [0, 2, 1, 3]
    assert (found["up"], found["likely_up"]) == (None, "Z")
    assert found["origin"] == [5.0, 6.0, 7.0]


def test_bones_say_which_elements_they_are(client: TestClient) -> None:
    uuid = stored(client, {"a.bvh": TWO_LEGS})
    root, *legs = client.get(f"{API}/{uuid}/skeleton").json()["bones"]
    assert root["address"] == "/mcml/root"
    for bone in legs:
        name = client.get(f"{API}/{uuid}/elements", params={"xpath": f"{bone['address']}/name"})
        assert name.text == f"<name>{bone['name']}</name>"


def test_stated_units_are_told_as_stated(client: TestClient) -> None:
    uuid = stored(client, {"a.bvh": TWO_LEGS}, unit="cm", up="y")
    found = client.get(f"{API}/{uuid}/skeleton").json()
    assert (found["unit"], found["likely_unit"], found["metres"], found["likely_up"]) == ("cm", "cm", 0.01, "Y")


def test_rest_axes_of_an_asf(client: TestClient) -> None:
    found = client.get(f"{API}/{stored(client, {'leg.asf': LEG, 'leg.amc': amc(2)})}/skeleton").json()
    turned = [bone for bone in found["bones"] if bone["axes"] != [0.0, 0.0, 0.0, 1.0]]
    assert turned
    assert all(abs(sum(part**2 for part in bone["axes"]) - 1) < 1e-12 for bone in turned)
    assert any(any(bone["along"]) for bone in found["bones"])


def test_markers_have_no_parents(client: TestClient) -> None:
    found = client.get(f"{API}/{stored(client, {'hand.trc': TRC})}/skeleton").json()
    assert found["markers"]
    assert {bone["parent"] for bone in found["bones"]} == {-1}
    assert found["origin"] == [273.71817, -56.52052, 1296.20001]
    assert (found["unit"], found["metres"]) == ("mm", 0.001)


def test_force_plates_are_named_where_their_forces_are_known(client: TestClient) -> None:
    uuid = stored(client, {"a.c3d": walkway()})
    (plate,) = client.get(f"{API}/{uuid}/skeleton").json()["plates"]
    assert plate == {"name": "1", "corners": [[300, 200, 0], [300, -200, 0], [-300, -200, 0], [-300, 200, 0]]}
    # The forces are in the unit of the file, which a corrected one is not.
    client.patch(f"{API}/{uuid}/calibration", json={"unit": "cm"}, headers={"if-match": "*"}).raise_for_status()
    (plate,) = client.get(f"{API}/{uuid}/skeleton").json()["plates"]
    assert plate["name"] is None
    assert client.get(f"{API}/{stored(client, {'a.bvh': TWO_LEGS})}/skeleton").json()["plates"] == []


@pytest.mark.parametrize("files", [{"a.bvh": bvh(2)}, {"a.htr": HTR}, {"leg.asf": LEG, "leg.amc": amc(2)}])
def test_columns_are_those_of_frames_as_numbers(client: TestClient, files: dict[str, bytes]) -> None:
    uuid = stored(client, files)
    found = client.get(f"{API}/{uuid}/skeleton").json()
    frames = client.get(f"{API}/{uuid}/frames", params={"format": "block"})
    assert ",".join(found["columns"]) == unquote(frames.headers["x-mcml-columns"])
    assert {(bone["name"], part) for bone in found["bones"] for part in bone["channels"]} == {
        tuple(column.rsplit(".", 1)) for column in found["columns"]
    }


def test_skeletons_of_documents_without_frames(client: TestClient) -> None:
    found = client.get(f"{API}/{stored(client, {'a.bvh': bvh(0)})}/skeleton").json()
    assert (found["frames"], found["origin"]) == (0, [0.0, 0.0, 0.0])


def test_what_a_revision_says_never_changes(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": bvh(5)})
    for path in ("skeleton?", "frames?", "frames?format=block&space=positions&dtype=f4&"):
        named = client.get(f"{API}/{uuid}/{path}revision=1")
        assert named.headers["cache-control"] == LASTING, path
        assert client.get(f"{API}/{uuid}/{path}").headers["cache-control"] == "private"
    known = {"if-none-match": named.headers["etag"]}
    again = client.get(f"{API}/{uuid}/{path}revision=1", headers=known)
    assert (again.status_code, again.headers["cache-control"]) == (304, LASTING)


@pytest.mark.parametrize("files", [{"a.bvh": bvh(600)}, {"leg.asf": LEG, "leg.amc": amc(40)}, {"hand.trc": TRC}])
def test_blocks_are_the_same_positions(client: TestClient, files: dict[str, bytes]) -> None:
    uuid = stored(client, files)
    whole = positions(client, uuid)
    origin = np.array(client.get(f"{API}/{uuid}/skeleton").json()["origin"])
    asked = {"space": "positions", "dtype": "f4", "format": "block", "origin": "subtract", "revision": 1}
    for first in range(1, len(whole) + 1, 256):
        last = min(first + 255, len(whole))
        answer = client.get(f"{API}/{uuid}/frames", params={**asked, "first": first, "last": last})
        assert answer.headers["x-mcml-origin"] == ",".join(map(repr, origin.tolist()))
        assert "content-encoding" not in answer.headers
        shape = tuple(map(int, answer.headers["x-mcml-shape"].split(",")))
        found = np.frombuffer(answer.content, "<f4").reshape(shape)
        if "hand.trc" not in files:
            np.testing.assert_array_equal(found, (whole[first - 1 : last] - origin).astype("<f4"))


def test_points_that_were_not_seen_are_nan_if_asked(client: TestClient) -> None:
    uuid = stored(client, {"hand.trc": TRC})
    held, gaps = positions(client, uuid), positions(client, uuid, missing="nan")
    gone = np.isnan(gaps)
    assert [tuple(place) for place in np.argwhere(gone.any(axis=2))] == [(1, 1), (2, 0), (3, 2)]
    np.testing.assert_array_equal(held[~gone], gaps[~gone])
    assert not np.isnan(held).any()
    alone = positions(client, uuid, missing="nan", first=3)
    np.testing.assert_array_equal(alone, gaps[2:], "a block says the same wherever it begins")


def test_a_missing_sample_takes_what_hangs_on_it_along(database: Database, client: TestClient) -> None:
    uuid = store(database, {"walk.bvh": bvh(3)})[0]
    place = {"xpath": "/mcml/motion/frame[2]/frame_bone[2]/@Rx"}
    assert client.delete(f"{API}/{uuid}/elements", params=place, headers={"if-match": "*"}).status_code == 200
    gone = np.isnan(positions(client, uuid, missing="nan")).any(axis=2)
    assert np.argwhere(gone).tolist() == [[1, 1], [1, 2]]


def test_only_positions_have_an_origin(client: TestClient) -> None:
    uuid = stored(client, {"walk.bvh": bvh(3)})
    for more in ({"space": "rotations", "format": "npy"}, {"space": "positions"}):
        answer = client.get(f"{API}/{uuid}/frames", params={"origin": "subtract", **more})
        assert (answer.status_code, "positions" in answer.json()["remedy"]) == (422, True)


def test_ends_of_chains_follow_the_bones(client: TestClient) -> None:
    uuid = stored(client, {"legs.bvh": TWO_LEGS})
    bones, tipped = positions(client, uuid), positions(client, uuid, tips=True)
    assert tipped.shape == (1, 7, 3)
    assert np.array_equal(tipped[:, :4], bones)
    tips = client.get(f"{API}/{uuid}/skeleton").json()["tips"]
    for place, tip in enumerate(tips):
        assert np.allclose(tipped[0, 4 + place], bones[0, tip["bone"]] + tip["offset"]), (
            "no bone is turned in this pose"
        )
    chosen = positions(client, uuid, tips=True, bone=["Head"], origin="subtract")
    assert np.allclose(chosen[0], tipped[0, [3, 6]] - bones[0, 0])
    refused = client.get(f"{API}/{uuid}/frames", params={"tips": True})
    assert refused.status_code == 422
    assert "space=positions" in refused.json()["remedy"]
