"""Mirror, smooth, adjust, resample over HTTP: what is meant changes, every other bit stays."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.formats import FORMATS
from mcml.motion.clip import ClipHead, ClipStream, FrameBlock, full_shape
from mcml.motion.markers import marker_skeleton
from mcml_service.demo import body
from tests.builders import one_kind
from tests.motion.edits.test_gap_filling import segment

API = "/api/v1"

pytestmark = one_kind
ANY = {"if-match": "*"}


@pytest.fixture
def uuid(client: TestClient) -> str:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 6.0, 1.0, 6.0))
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    answer = client.post(f"{API}/documents", files=[("file", ("walk.bvh", content))], data={"label": "walk:50-300"})
    return str(answer.json()["documents"][0]["id"])


def values(client: TestClient, uuid: str, **more: str) -> np.ndarray:
    plain = {"accept-encoding": "identity"}
    answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npy", **more}, headers=plain)
    assert answer.headers["content-length"] == str(len(answer.content))
    return np.load(io.BytesIO(answer.content))


def edit(client: TestClient, uuid: str, **what: object) -> dict[str, object]:
    answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": [what]}, headers=ANY)
    assert answer.status_code == 200, answer.text
    found: dict[str, object] = answer.json()
    return found


def test_mirrored_twice_is_the_same(client: TestClient, uuid: str) -> None:
    before, positions = values(client, uuid), values(client, uuid, space="positions")
    edit(client, uuid, do="mirror", first=1, last=360)
    mirrored = values(client, uuid, space="positions")
    bones = client.get(f"{API}/documents/{uuid}").json()["bones"]
    names = [bone["name"] for bone in bones]
    other = [names.index(name.replace("left", "\0").replace("right", "left").replace("\0", "right")) for name in names]
    flipped = positions[:, other] * np.array([-1.0, 1.0, 1.0])
    offset = mirrored[:, :1] - flipped[:, :1]
    assert np.abs(mirrored - flipped - offset).max() < 1e-6
    edit(client, uuid, do="mirror", first=1, last=360)
    assert np.abs(values(client, uuid) - before).max() < 1e-6
    assert client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='walk'])"}).json()["value"] == 251


def test_smoothing_and_adjusting_leave_the_rest_as_it_is(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    columns = client.get(f"{API}/documents/{uuid}/frames?format=npy").headers["x-mcml-columns"].split(",")
    edit(client, uuid, do="smooth", first=100, last=200, seconds=0.1, bones=["left_up_arm"])
    after = values(client, uuid)
    arm = [i for i, name in enumerate(columns) if name.startswith("left_up_arm.")]
    rest = [i for i in range(len(columns)) if i not in arm]
    assert np.array_equal(after[:, rest], before[:, rest])
    assert np.array_equal(np.delete(after, range(99, 200), 0), np.delete(before, range(99, 200), 0))
    assert np.abs(np.diff(after[99:200, arm], 2, axis=0)).sum() < np.abs(np.diff(before[99:200, arm], 2, axis=0)).sum()
    edit(client, uuid, do="adjust", first=1, last=360, channels=["Ty"], factor=2.0, offset=1.0)
    lifted = values(client, uuid)
    y = columns.index("Root.Ty")
    assert np.array_equal(lifted[:, y], after[:, y] * 2 + 1)
    assert np.array_equal(np.delete(lifted, y, 1), np.delete(after, y, 1))


def test_resampling_keeps_what_is_at_common_times(client: TestClient, uuid: str) -> None:
    before = values(client, uuid, space="positions")
    done = edit(client, uuid, do="resample", rate=30)
    assert done["frames"] == 180
    found = client.get(f"{API}/documents/{uuid}").json()
    assert found["seconds_per_frame"] == pytest.approx(1 / 30)
    half = values(client, uuid, space="positions")
    # The file says 0.0166667 s a frame, so that its times drift from those of 30 Hz by 2e-8 of a second a frame.
    assert np.abs(half - before[::2][:180]).max() < 1e-3 * 170
    assert client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='walk'])"}).json()["value"] in (125, 126)
    client.post(f"{API}/documents/{uuid}/undo", headers=ANY)
    assert np.array_equal(values(client, uuid, space="positions"), before)


def test_what_cannot_be(client: TestClient, uuid: str) -> None:
    for what in (
        {"do": "smooth", "first": 1, "last": 5, "bones": ["tail"]},
        {"do": "adjust", "first": 1, "last": 5, "channels": ["SF"]},
        {"do": "resample", "rate": 0},
        {"do": "mirror", "first": 1, "last": 999},
    ):
        answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": [what]}, headers=ANY)
        assert answer.status_code in (404, 422), answer.text
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1


def holed_trial() -> bytes:
    """Markers of a stiff segment at 100 frames a second, one of them missing in frames 21 to 60, one in 81 to 84."""
    places = segment()
    places[20:60, 1] = np.nan
    places[80:84, 2] = np.nan
    skeleton = marker_skeleton([f"M{place}" for place in range(places.shape[1])])
    columns = skeleton.columns()
    frames = FrameBlock(places.reshape(len(places), -1), columns, (full_shape(columns),), np.arange(1, len(places) + 1))
    head = ClipHead("trc", skeleton, {"dataframe_rate": "100", "calibration_unit": "mm"}, frame_time="0.01")
    return b"".join(FORMATS["trc"].write(ClipStream(head, lambda: iter([frames]), frames=len(places)), "trc"))


@pytest.fixture
def trial(client: TestClient) -> str:
    answer = client.post(f"{API}/documents", files=[("file", ("trial.trc", holed_trial()))])
    return str(answer.json()["documents"][0]["id"])


def test_gaps_are_filled_as_the_dry_run_says(client: TestClient, trial: str) -> None:
    before = values(client, trial, missing="nan")
    fill = {"edits": [{"do": "fill", "first": 1, "last": 200}]}
    dry = client.post(f"{API}/documents/{trial}/frames", params={"dry_run": True}, json=fill, headers=ANY).json()
    assert dry["revision"] == 1
    assert sorted(dry["notes"]) == ["4 samples filled by spline", "40 samples filled by segment"]
    assert np.array_equal(values(client, trial, missing="nan"), before, equal_nan=True)
    done = edit(client, trial, do="fill", first=1, last=200)
    assert (done["revision"], done["notes"]) == (2, dry["notes"])
    after = values(client, trial, missing="nan").reshape(200, -1)
    assert np.abs(after - segment().reshape(200, -1)).max() < 0.05
    client.post(f"{API}/documents/{trial}/undo", headers=ANY)
    assert np.array_equal(values(client, trial, missing="nan"), before, equal_nan=True)


def test_gaps_longer_than_asked_stay(client: TestClient, trial: str) -> None:
    done = edit(client, trial, do="fill", first=1, last=200, longest=0.1)
    left = "40 samples stay missing: gaps over 0.1 s, or that no other marker tells"
    assert done["notes"] == ["4 samples filled by spline", left]
    assert edit(client, trial, do="fill", first=1, last=10)["notes"] == ["no gaps between known samples"]


def test_a_filter_takes_noise_and_tells_its_cut_off(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    edit(client, uuid, do="low-pass", first=100, last=200, hertz=4, bones=["left_up_arm"])
    after = values(client, uuid)
    assert np.array_equal(np.delete(after, range(99, 200), 0), np.delete(before, range(99, 200), 0))
    assert np.abs(np.diff(after[99:200], 2, axis=0)).sum() < np.abs(np.diff(before[99:200], 2, axis=0)).sum()
    refused = client.post(
        f"{API}/documents/{uuid}/frames",
        json={"edits": [{"do": "low-pass", "first": 1, "last": 9, "hertz": 60}]},
        headers=ANY,
    )
    assert refused.status_code == 422
    assert "half of the frame rate" in refused.json()["remedy"]


def test_unrolled_angles_are_the_same_poses(client: TestClient, uuid: str) -> None:
    before = values(client, uuid, space="positions")
    columns = client.get(f"{API}/documents/{uuid}/frames?format=npy").headers["x-mcml-columns"].split(",")
    edit(client, uuid, do="adjust", first=50, last=60, channels=["Rz"], offset=360, bones=["left_up_arm"])
    arm = columns.index("left_up_arm.Rz")
    assert np.abs(np.diff(values(client, uuid)[:, arm])).max() > 300
    assert edit(client, uuid, do="unroll")["notes"] == ["11 rotations have other angles"]
    assert np.abs(np.diff(values(client, uuid)[:, arm])).max() < 90
    assert np.abs(values(client, uuid, space="positions") - before).max() < 1e-6


def test_locked_feet_slide_less_and_can_be_taken_back(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    foot = {"bone": "left_foot", "space": "positions"}
    course = values(client, uuid, **foot)
    notes = edit(client, uuid, do="lock-feet", first=1, last=360, sides=["left"])["notes"]
    assert isinstance(notes, list)
    count, slid, left = re.findall(r"[\d.]+", notes[0])
    assert int(count) > 2
    assert float(left) < 0.2 * float(slid)
    after = values(client, uuid, **foot)
    assert 0 < np.abs(after - course).max() < 0.3 * np.ptp(values(client, uuid, space="positions")[0])
    assert client.post(f"{API}/documents/{uuid}/undo", headers=ANY).status_code == 200
    assert np.array_equal(values(client, uuid), before)
    nothing = edit(client, uuid, do="lock-feet", first=1, last=2)
    assert nothing["notes"] == ["no foot stands in these frames"]


def test_feet_of_markers_cannot_be_locked(client: TestClient, trial: str) -> None:
    refused = client.post(
        f"{API}/documents/{trial}/frames", json={"edits": [{"do": "lock-feet", "first": 1, "last": 9}]}, headers=ANY
    )
    assert refused.status_code == 422
    assert "leg from hip to knee to ankle" in refused.json()["detail"]
    assert "map the joints" in refused.json()["remedy"]


def test_a_loop_ends_where_it_begins(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    notes = edit(client, uuid, do="loop", first=21, last=340, in_place=True)["notes"]
    assert isinstance(notes, list)
    first, last = (int(number) for number in re.findall(r"frames (\d+) to (\d+)", notes[0])[0])
    assert 21 <= first < last <= 340
    assert client.get(f"{API}/documents/{uuid}").json()["frames"] == last - first + 1
    there = values(client, uuid, space="positions")
    # One round later the body is where it was, but for one step.
    step = np.abs(np.diff(there, axis=0)).max()
    assert np.abs(there[0] - there[-1]).max() <= 1.5 * step
    client.post(f"{API}/documents/{uuid}/undo", headers=ANY)
    assert np.array_equal(values(client, uuid), before)
    whole = edit(client, uuid, do="loop", first=1, last=360, search=0, seconds=0.2)["notes"]
    assert isinstance(whole, list)
    assert "frames 1 to 360 are the loop" in whole[0]
    # Nothing but the end was changed.
    assert np.array_equal(values(client, uuid)[:340], before[:340])
    refused = client.post(
        f"{API}/documents/{uuid}/frames", json={"edits": [{"do": "loop", "first": 1, "last": 3}]}, headers=ANY
    )
    assert refused.status_code == 422
    assert "at least 4 frames" in refused.json()["detail"]


def test_spikes_are_replaced_and_told(client: TestClient, uuid: str) -> None:
    def roots() -> list[dict[str, object]]:
        answer = client.get(f"{API}/documents/{uuid}/frames", params={"bone": "Root", "limit": 500})
        return [item["values"]["Root"] for item in answer.json()["items"]]

    before = roots()
    put = {"columns": ["Root.Tx"], "values": [[float(str(before[99]["Tx"])) + 70]]}
    written = client.put(f"{API}/documents/{uuid}/frames", json=put, params={"first": 100}, headers=ANY)
    assert written.status_code == 200, written.text
    told = edit(client, uuid, do="despike", first=1, last=200, bones=["Root"])
    assert told["notes"] == ["spikes replaced: 1 (Root 1)", "first in frame 100, last in frame 100"]
    after = roots()
    assert after[99]["Tx"] == pytest.approx(before[99]["Tx"], abs=0.2)
    assert after[:99] + after[100:] == before[:99] + before[100:]
    even = {"edits": [{"do": "despike", "first": 1, "last": 9, "window": 4}]}
    answer = client.post(f"{API}/documents/{uuid}/frames", json=even, headers={"if-match": "*"})
    assert answer.status_code == 422
    assert "no middle" in answer.json()["detail"]


def test_faster_frames_are_fewer_and_labels_go_with_them(client: TestClient, uuid: str) -> None:
    before = values(client, uuid)
    made = edit(client, uuid, do="speed", first=101, last=200, factors=[2.0])
    assert made["frames"] == 310
    assert made["notes"] == ["frames of the range: 100 before, 50 after"]
    after = values(client, uuid)
    assert np.array_equal(after[:100], before[:100])
    assert np.array_equal(after[100:150], before[100:200:2])
    assert np.array_equal(after[150:], before[200:])
    assert client.get(f"{API}/xpath", params={"q": "count(//frame[motion_name='walk'])"}).json()["value"] == 201
    slower = edit(client, uuid, do="speed", first=1, last=310, factors=[1.0, 0.5, 1.0])
    assert 310 < int(str(slower["frames"])) < 620


def test_in_place_the_body_stays_and_later_frames_go_on(client: TestClient, uuid: str) -> None:
    before, positions = values(client, uuid), values(client, uuid, space="positions")
    made = edit(client, uuid, do="in-place", first=1, last=180)
    assert made["frames"] == 360
    notes = made["notes"]
    assert isinstance(notes, list)
    assert re.fullmatch(r"a way of 380\.\d units was taken out", notes[0])
    assert notes[1:] == ["the frames from 181 on go on from there"]
    after = values(client, uuid, space="positions")
    assert np.ptp(after[:180, 0, [0, 2]], axis=0).max() < 1e-6
    assert np.allclose(after[:, :, 1], positions[:, :, 1], atol=1e-6)
    assert np.allclose(np.diff(after[180:], axis=0), np.diff(positions[180:], axis=0), atol=1e-6)
    assert edit(client, uuid, do="in-place", first=1, last=180)["notes"] == ["the body does not travel in these frames"]
    assert values(client, uuid).shape == before.shape


def test_a_hand_is_moved_on_top_of_the_motion(client: TestClient, uuid: str) -> None:
    before, course = values(client, uuid), values(client, uuid, space="positions")
    names = [bone["name"] for bone in client.get(f"{API}/documents/{uuid}").json()["bones"]]
    handles = [{"handle": "left_hand", "move": [0, 8, 3]}, {"handle": "hips", "move": [0, -4, 0]}]
    assert edit(client, uuid, do="pose", first=101, last=161, ease=20, handles=handles)["notes"] == []
    moved = values(client, uuid, space="positions") - course
    hand, foot, hips = (names.index(name) for name in ("left_hand", "left_foot", "Root"))
    assert moved[130, hand] == pytest.approx([0, 8, 3], abs=1e-3)
    assert moved[130, hips] == pytest.approx([0, -4, 0], abs=1e-3)
    assert np.abs(moved[:, foot]).max() < 1e-3
    assert 0 < moved[101, hand, 1] < moved[110, hand, 1] < 8
    after = values(client, uuid)
    changed = np.flatnonzero((after != before).any(axis=1))
    assert (changed.min(), changed.max()) == (100, 160)
    client.post(f"{API}/documents/{uuid}/undo", headers=ANY)
    assert np.array_equal(values(client, uuid), before)
    (note,) = edit(client, uuid, do="pose", first=1, last=9, handles=[{"handle": "head", "move": [0, 90, 0]}])["notes"]
    assert re.fullmatch(r"head: up to [\d.]+ units from its goal", note)


@pytest.mark.parametrize(
    ("handles", "reason"),
    [
        ([{"handle": "left_hand", "move": [0, 1, 0]}, {"handle": "left_hand", "turn": [0, 9, 0]}], "moved twice"),
        ([{"handle": "left_ear", "move": [0, 1, 0]}], "left_ear|hips"),
        ([{"handle": "hips", "move": [0, 1e12, 0]}], "less than or equal"),
        ([], "at least 1"),
    ],
)
def test_handles_that_mean_nothing_are_refused(client: TestClient, uuid: str, handles: object, reason: str) -> None:
    body = {"edits": [{"do": "pose", "first": 1, "last": 9, "handles": handles}]}
    refused = client.post(f"{API}/documents/{uuid}/frames", json=body, headers=ANY)
    assert refused.status_code == 422
    assert re.search(reason, refused.text)


def test_markers_have_no_handles(client: TestClient, trial: str) -> None:
    body = {"edits": [{"do": "pose", "first": 1, "last": 9, "handles": [{"handle": "head", "move": [0, 1, 0]}]}]}
    refused = client.post(f"{API}/documents/{trial}/frames", json=body, headers=ANY)
    assert refused.status_code == 422
    assert refused.json()["detail"].startswith("the skeleton has no handle head")
