"""Curves before and after edits of frames: what a dry run shows is what the same edit gives."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mcml.formats import FORMATS
from mcml_service.demo import body
from tests.api.test_reshaping import holed_trial
from tests.builders import one_kind

API = "/api/v1"
ANY = {"if-match": "*"}
FRAMES = 360
COLUMNS = ["Root.Ty", "left_up_arm.Rx", "left_low_leg.Rz"]
QUANTITIES = ["height:left_hand", "speed:right_hand,Root", "angle:left-knee-flexion"]

pytestmark = one_kind


@pytest.fixture
def uuid(client: TestClient) -> str:
    clip = body.clip("walk", 170.0, *body.walk(170.0, 6.0, 1.0, 6.0))
    content = b"".join(FORMATS["bvh"].write(clip, "bvh"))
    answer = client.post(f"{API}/documents", files=[("file", ("walk.bvh", content))])
    return str(answer.json()["documents"][0]["id"])


@pytest.fixture
def trial(client: TestClient) -> str:
    answer = client.post(f"{API}/documents", files=[("file", ("trial.trc", holed_trial()))])
    return str(answer.json()["documents"][0]["id"])


def preview(client: TestClient, uuid: str, *edits: dict[str, Any], **asked: Any) -> dict[str, Any]:
    answer = client.post(
        f"{API}/documents/{uuid}/frames", params={"dry_run": True, **asked}, json={"edits": edits}, headers=ANY
    )
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def make(client: TestClient, uuid: str, *edits: dict[str, Any]) -> dict[str, Any]:
    answer = client.post(f"{API}/documents/{uuid}/frames", json={"edits": edits}, headers=ANY)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def table(client: TestClient, uuid: str) -> dict[str, np.ndarray]:
    """All channels and QUANTITIES, as the operation that reads frames has them."""
    found: dict[str, np.ndarray] = {}
    bones = sorted({name.rpartition(".")[0] for name in COLUMNS})
    for asked in ({"bone": bones}, {"quantity": QUANTITIES}):
        answer = client.get(f"{API}/documents/{uuid}/frames", params={"format": "npz", **asked})
        file = np.load(io.BytesIO(answer.content))
        found |= dict(zip(file["columns"].tolist(), file["values"].T, strict=True))
    return found


def numbers(values: list[float | None]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values])


def ranges(first: int, last: int) -> st.SearchStrategy[tuple[int, int]]:
    return st.tuples(st.integers(first, last), st.integers(first, last)).map(lambda ends: (min(ends), max(ends)))


@st.composite
def edits(draw: st.DrawFn) -> dict[str, Any]:
    first, last = draw(ranges(1, FRAMES))
    ranged = {"first": first, "last": last}
    return draw(
        st.sampled_from(
            [
                {"do": "reverse", **ranged},
                {"do": "mirror", **ranged},
                {"do": "smooth", **ranged, "seconds": 0.1},
                {"do": "low-pass", **ranged, "hertz": 4},
                {"do": "despike", **ranged, "deviations": 2},
                {"do": "lock-feet", **ranged},
                {"do": "adjust", **ranged, "channels": ["Ty", "Rx"], "factor": 1.5},
                {"do": "unroll"},
                {"do": "resample", "rate": 40},
                {"do": "keep", **ranged},
                {"do": "move", **ranged, "to": 1},
            ]
        )
    )


@pytest.mark.slow
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
@given(some=st.lists(edits(), min_size=1, max_size=1), pixels=st.sampled_from([1, 7, 300, 2000]))
def test_curves_are_those_of_the_document_and_of_the_edit(
    client: TestClient, uuid: str, some: list[dict[str, Any]], pixels: int
) -> None:
    old = client.get(f"{API}/documents/{uuid}").json()
    history = client.get(f"{API}/documents/{uuid}/revisions").json()
    before = table(client, uuid)
    dry = preview(client, uuid, *some, column=COLUMNS, quantity=QUANTITIES, pixels=pixels)
    assert client.get(f"{API}/documents/{uuid}").json() == old
    assert client.get(f"{API}/documents/{uuid}/revisions").json() == history
    assert dry["revision"] == old["revision"]
    for name, values in table(client, uuid).items():
        assert np.array_equal(values, before[name], equal_nan=True)
    done = make(client, uuid, *some)
    assert done["curves"] == []
    assert (done["frames"], done["notes"]) == (dry["frames"], dry["notes"])
    after = table(client, uuid)
    assert [curve["name"] for curve in dry["curves"]] == COLUMNS + QUANTITIES
    for curve in dry["curves"]:
        for side, whole in (("before", before), ("after", after)):
            shown = curve[side]
            low, high = numbers(shown["minimum"]), numbers(shown["maximum"])
            assert len(low) == len(high) <= pixels
            rest = whole[curve["name"]][shown["first"] - 1 :]
            for place in range(len(low)):
                part = rest[place * shown["step"] : (place + 1) * shown["step"]]
                if place == len(low) - 1 and "last" in some[0] and some[0]["do"] not in ("keep", "move"):
                    part = part[: some[0]["last"] - shown["first"] + 1 - place * shown["step"]]
                if np.isnan(part).all():
                    assert np.isnan([low[place], high[place]]).all()
                else:
                    assert (low[place], high[place]) == (np.nanmin(part), np.nanmax(part))
            covered = len(low) * shown["step"]
            own = len(rest) if some[0]["do"] in ("keep", "move", "resample", "unroll") else None
            assert covered >= (own if own is not None else some[0]["last"] - some[0]["first"] + 1)
    client.post(f"{API}/documents/{uuid}/undo", headers=ANY)


def test_a_dry_run_leaves_no_trace_in_later_answers(client: TestClient, uuid: str) -> None:
    """The edit that follows has the revision number of the dry run, and other values."""
    lift = {"do": "adjust", "first": 1, "last": FRAMES, "channels": ["Ty"], "offset": 50.0}
    shown = preview(client, uuid, lift, quantity=["height:left_hand"])["curves"][0]["after"]["minimum"]
    sink = lift | {"offset": -20.0}
    expected = preview(client, uuid, sink, quantity=["height:left_hand"])["curves"][0]["after"]["minimum"]
    make(client, uuid, sink)
    assert table(client, uuid)["height:left_hand"].tolist() == expected
    assert shown != expected


def test_missing_samples_are_null_until_they_are_filled(client: TestClient, trial: str) -> None:
    fill = {"do": "fill", "first": 15, "last": 90}
    (curve,) = preview(client, trial, fill, column=["M1.Tx"])["curves"]
    for side, missing in (("before", set(range(21, 61))), ("after", set())):
        shown = curve[side]
        assert (shown["first"], shown["step"], len(shown["minimum"])) == (15, 1, 76)
        assert {15 + place for place, value in enumerate(shown["minimum"]) if value is None} == missing
        assert shown["minimum"] == shown["maximum"]


def test_whole_chunks_of_long_clips_are_read_after_the_edit(client: TestClient, uuid: str) -> None:
    """From 256 frames a range on, extremes come from zone maps, which the edit has written anew."""
    lift = {"do": "adjust", "first": 1, "last": FRAMES, "channels": ["Ty"], "offset": 50.0}
    (curve,) = preview(client, uuid, lift, column=["Root.Ty"], pixels=1)["curves"]
    assert curve["before"]["step"] == curve["after"]["step"] == 512
    for end in ("minimum", "maximum"):
        assert curve["after"][end] == pytest.approx([value + 50.0 for value in curve["before"][end]])


def test_filled_markers_are_listed_with_their_frames(client: TestClient, trial: str) -> None:
    fill = {"do": "fill", "first": 15, "last": 90}
    for answer in (preview(client, trial, fill), make(client, trial, fill)):
        told = [(item["bone"], item["frames"], item["ranges"]) for item in answer["replaced"]]
        assert told == [("M1", 40, [{"first": 21, "last": 60}]), ("M2", 4, [{"first": 81, "last": 84}])]
        assert all({"Tx", "Ty", "Tz"} <= set(item["channels"]) for item in answer["replaced"])


def test_the_channel_of_a_spike_is_listed_first(client: TestClient, uuid: str) -> None:
    spike = {"do": "adjust", "first": 100, "last": 100, "channels": ["Ty"], "offset": 300.0, "bones": ["Root"]}
    make(client, uuid, spike)
    (replaced,) = preview(client, uuid, {"do": "despike", "first": 50, "last": 200, "bones": ["Root"]})["replaced"]
    assert (replaced["bone"], replaced["channels"][0]) == ("Root", "Ty")
    assert replaced["ranges"] == [{"first": 100, "last": 100}]


@pytest.mark.parametrize("do", ["keep", "loop"])
def test_kept_frames_are_found_in_the_document_before(client: TestClient, uuid: str, do: str) -> None:
    edit = {"do": do, "first": 31, "last": 180}
    dry = preview(client, uuid, edit, column=["left_up_arm.Rx"])
    (curve,) = dry["curves"]
    start = dry["first_kept"]
    before, after = (numbers(curve[side]["minimum"]) for side in ("before", "after"))
    assert len(after) == dry["frames"]
    # Only the end of a loop is changed.
    assert np.array_equal(after[:20], before[start - 1 : start + 19])
    assert preview(client, uuid, edit, {"do": "reverse", "first": 1, "last": 9})["first_kept"] is None


@pytest.mark.parametrize(
    ("asked", "status", "part"),
    [
        ({"column": "tail.Rx"}, 404, "no bone 'tail'"),
        ({"column": "Root.SF"}, 404, "no channel 'Root.SF'"),
        ({"column": "Root"}, 422, "BONE.CHANNEL"),
        ({"quantity": "height:tail"}, 404, "no bone 'tail'"),
        ({"quantity": "highness:left_hand"}, 422, "highness"),
        ({"quantity": "force:1,x"}, 404, "no force plate"),
        ({"column": ["Root.Tx", *COLUMNS], "quantity": [*QUANTITIES, "time", "height:Root"]}, 422, "at most 8"),
        ({"column": "Root.Tx", "pixels": 2001}, 422, "pixels"),
    ],
)
def test_unknown_curves_are_refused(
    client: TestClient, uuid: str, asked: dict[str, Any], status: int, part: str
) -> None:
    edit = {"edits": [{"do": "unroll"}]}
    answer = client.post(f"{API}/documents/{uuid}/frames", params={"dry_run": True, **asked}, json=edit, headers=ANY)
    assert answer.status_code == status, answer.text
    assert part in answer.text
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1


def test_curves_without_a_dry_run_are_refused(client: TestClient, uuid: str) -> None:
    edit = {"edits": [{"do": "unroll"}]}
    answer = client.post(f"{API}/documents/{uuid}/frames", params={"column": "Root.Tx"}, json=edit, headers=ANY)
    assert answer.status_code == 422
    assert "dry_run=true" in answer.json()["remedy"]
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1


def test_a_dry_run_previews_the_edited_motion(client: TestClient, uuid: str) -> None:
    url = f"{API}/documents/{uuid}/frames"
    body = {"edits": [{"do": "keep", "first": 11, "last": 20}]}
    query = {"dry_run": "true", "positions": "f4", "step": "3"}
    answer = client.post(url, json=body, params=query, headers=ANY).json()
    motion = answer["motion"]
    assert motion["shape"][0] == 4
    values = np.frombuffer(base64.b64decode(motion["data"]), "<f4").reshape(motion["shape"])
    stored = np.load(io.BytesIO(client.get(f"{url}?format=npy&space=positions").content))
    shown = values[:, : stored.shape[1]] + motion["origin"]
    assert np.allclose(shown, stored[10:20:3], atol=1e-3)
    refused = client.post(url, json=body, params={"positions": "f4"}, headers=ANY)
    assert refused.status_code == 422
    assert "dry run" in refused.json()["detail"]
