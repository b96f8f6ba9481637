"""Bodies of documents that are kept: as they are worked out, at every revision, whatever happens to what is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient
from numpy.typing import NDArray
from sqlalchemy import text

from mcml.errors import StoreError
from mcml.motion.bodies.positions import UNSEEN, clip_positions, filled, rounded
from mcml.motion.units import reading_of
from mcml_service.actions.editing.whole_document import add_labels, change_document, delete_document
from mcml_service.actions.keeping.keep_room import prune_history
from mcml_service.clips.bodies import Body, read_bodies
from mcml_service.clips.derive import derive_missing
from mcml_service.clips.read_clip import read_clip
from mcml_service.storage.database import Database
from mcml_service.storage.documents import packed_positions
from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from tests.builders import TRC, bvh, one_kind, store

pytestmark = pytest.mark.above_store

NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot")


def silent(done: int, of: int) -> None:
    """Told how many are done."""


def kept(database: Database) -> list[tuple[int, int]]:
    """(document, revision) of each body."""
    with database.read() as tx:
        rows = tx.connection.execute(text("SELECT DISTINCT document, revision FROM body ORDER BY 1, 2"))
        return [(row[0], row[1]) for row in rows]


def listed(tx: Transaction) -> list[Listed]:
    return tx.columns.documents()


def places(body: Body) -> dict[str, NDArray[np.int32]]:
    return dict(body.stretch(body.names).places)


def same(one: Body, other: Body) -> bool:
    """Whether nothing tells two bodies apart."""
    if one.facts() != other.facts():
        return False
    mine, others = places(one), places(other)
    return all(np.array_equal(mine[name], others[name]) for name in one.names)


def obvious(tx: Transaction, document: Listed, body: Body) -> NDArray[np.int32]:
    """Its positions, worked out alone and in another way of reading."""
    clip = read_clip(tx, tx.documents.get(document.uuid)).clip
    skeleton = clip.head.skeleton
    (found,) = clip_positions(skeleton, [filled(skeleton, clip.blocks())], reading_of(clip.head))
    return rounded(found, body.calibration.step)


def many(database: Database, count: int = 7) -> list[str]:
    """Documents of two skeletons, long and short, markers, and one without frames."""
    files = {f"{n}.bvh": bvh(5 + 40 * n, seed=n, names=NAMES[: 3 + n % 2]) for n in range(count)}
    return store(database, {**files, "points.trc": TRC, "empty.bvh": bvh(0)})


def test_what_is_kept_is_what_is_worked_out(database: Database) -> None:
    many(database)
    with database.read() as tx:
        before = read_bodies(tx, listed(tx))
        for document in listed(tx):
            body = before[document.key]
            expected = obvious(tx, document, body)
            assert all(np.array_equal(found, expected[:, n]) for n, found in enumerate(places(body).values()))
    told: list[tuple[int, int]] = []
    assert derive_missing(database, lambda *at: told.append(at)) == 9
    assert told[-1] == (9, 9)
    assert len(kept(database)) == 9
    with database.read() as tx:
        after = read_bodies(tx, listed(tx))
        assert all(same(before[key], after[key]) for key in before)
    assert derive_missing(database, silent) == 0
    assert database.check() == []


def test_revisions_that_move_something_have_bodies_of_their_own(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"a.bvh": bvh(60, names=NAMES)})
    derive_missing(database, silent)
    steps_of = lambda tx: read_bodies(tx, listed(tx))  # noqa: E731  # short
    with database.write("a") as tx:
        first = steps_of(tx)
        stored = tx.documents.get(uuid)
        add_labels(tx, stored, [("walk", 1, 20)])
    with database.read() as tx:
        assert [same(one, other) for one, other in zip(first.values(), steps_of(tx).values(), strict=True)] == [True]
    assert derive_missing(database, silent) == 0, "a name moves nothing"
    edits = {"edits": [{"do": "delete", "first": 10, "last": 29}]}
    answer = client.post(f"/api/v1/documents/{uuid}/frames", json=edits, headers={"if-match": "*"})
    assert answer.status_code == 200, answer.text
    with database.read() as tx:
        (cut,), (whole,) = steps_of(tx).values(), first.values()
        expected = np.delete(places(whole)["left_up_leg"], np.s_[9:29], axis=0)
        assert cut.frames == 40
        assert np.array_equal(places(cut)["left_up_leg"], expected)
        past = tx.at_commit(tx.documents.commit_of(tx.documents.get(uuid).key, 2))
        (then,) = read_bodies(past, past.columns.documents()).values()
        assert same(then, whole)
    assert derive_missing(database, silent) == 1
    assert [number for _, number in kept(database)] == [1, 3]
    prune_history(database, 0, do=True)
    assert [number for _, number in kept(database)] == [3]
    assert database.check() == []


@pytest.mark.parametrize("damage", ["data = x'00'", "facts = '{}'", "checksum = 1"])
def test_what_is_damaged_counts_as_not_there(database: Database, damage: str) -> None:
    many(database, 3)
    derive_missing(database, silent)
    with database.read() as tx:
        before = read_bodies(tx, listed(tx))
    if database.name == "postgresql":
        damage = damage.replace("x'00'", r"'\x00'")
    with database.write("a") as tx:
        tx.connection.execute(text(f"UPDATE body SET {damage} WHERE document = (SELECT min(document) FROM body)"))
    assert database.check(), "and is told"
    with database.read() as tx:
        after = read_bodies(tx, listed(tx))
        assert all(same(before[key], after[key]) for key in before)
    assert derive_missing(database, silent) >= 1
    assert database.check() == []


def test_it_can_be_stopped_and_goes_on(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    many(database)
    monkeypatch.setattr("mcml_service.clips.derive.TOGETHER", 2)

    def stop(done: int, of: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        derive_missing(database, stop)
    assert len(kept(database)) == 4
    assert derive_missing(database, silent) == 5
    assert database.check() == []


def test_documents_that_go_meanwhile_are_passed_over(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    uuids = many(database, 3)
    monkeypatch.setattr("mcml_service.clips.derive.TOGETHER", 1)
    gone: list[str] = []

    def remove(done: int, of: int) -> None:
        if not gone:
            gone.append(uuids[1])
            with database.write("a") as tx:
                delete_document(tx, tx.documents.get(uuids[1]))

    derive_missing(database, remove)
    assert len(kept(database)) == 4
    assert database.check() == []


def test_a_calibration_that_people_set_counts(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"a.bvh": bvh(60, names=NAMES)})
    derive_missing(database, silent)
    place = f"/api/v1/documents/{uuid}/calibration"
    shown = client.get(place).json()
    assert (shown["kept"], shown["floor"]["origin"], shown["leaps"]["value"]) == (True, "guessed", False)
    asked = {"unit": "cm", "floor": -3.5, "leg": 21, "reference": 12, "leaps": True}
    changed = client.patch(place, json=asked, headers={"if-match": "*"}).json()
    assert changed["unit"] == {"value": "cm", "metres": 0.01, "origin": "stated", "reason": "cm"}
    for name, value in (("floor", -3.5), ("leg", 21), ("reference", 12), ("leaps", True)):
        assert (changed[name]["value"], changed[name]["origin"]) == (value, "set")
    assert changed["kept"] is False, "what was kept is of another calibration"
    with database.read() as tx:
        (body,) = read_bodies(tx, listed(tx)).values()
        assert (body.calibration.floor, body.calibration.reference, body.calibration.step) == (-3.5, 11, 0.01)
    derive_missing(database, silent)
    assert client.get(place).json() == changed | {"kept": True}
    assert client.get(place, params={"revision": 1}).json() == shown
    back = client.patch(place, json=dict.fromkeys(asked), headers={"if-match": "*"}).json()
    assert {**back, "kept": True} == shown
    assert client.get(f"/api/v1/documents/{uuid}").json()["revision"] == 3
    for wrong in ({"reference": 61}, {"leg": 0}, {"unit": "parsec"}, {"reference": "sitting"}, {"hips": 1}):
        assert client.patch(place, json=wrong, headers={"if-match": "*"}).status_code == 422, wrong
    assert client.patch(place, json={"floor": 1}, headers={"if-match": '"1"'}).status_code == 412
    assert client.patch(place, json={}, headers={"if-match": "*"}).status_code == 200
    assert client.get(f"/api/v1/documents/{uuid}").json()["revision"] == 3, "nothing was asked"
    assert database.check() == []


def test_a_reference_pose_stays_though_its_frame_is_gone(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"a.bvh": bvh(30, names=(*NAMES, "LeftToe"))})
    place = f"/api/v1/documents/{uuid}"
    client.patch(f"{place}/calibration", json={"reference": 29, "up": "Y"}, headers={"if-match": "*"})
    edits = {"edits": [{"do": "keep", "first": 1, "last": 10}]}
    assert client.post(f"{place}/frames", json=edits, headers={"if-match": "*"}).status_code == 200
    known = client.get(f"{place}/calibration").json()["reference"]
    assert (known["origin"], known["value"]) == ("set", 29)
    asked = {"q": "count(//frame[mo:angle('left-foot-inversion') > 0])"}
    assert client.get("/api/v1/xpath", params=asked).status_code == 200
    assert client.get(f"{place}/export", params={"format": "mot"}).status_code in (200, 422)


def test_other_properties_stay_as_they_are(database: Database, client: TestClient) -> None:
    (uuid,) = store(database, {"a.bvh": bvh(9, names=NAMES)})
    held = [{"name": "shoe", "value": "left", "unit": ""}, {"name": "shoe", "value": "right", "unit": "size"}]
    place = f"/api/v1/documents/{uuid}"
    changed = client.patch(place, json={"properties": held}, headers={"if-match": "*"}).json()["properties"]
    client.patch(f"{place}/calibration", json={"floor": 1, "unit": "cm"}, headers={"if-match": "*"})
    own = {"name": "calibration floor", "value": "1.0", "unit": ""}
    assert client.get(place).json()["properties"] == [*changed, own]
    client.patch(f"{place}/calibration", json={"floor": None}, headers={"if-match": "*"})
    assert client.get(place).json()["properties"] == changed


@pytest.mark.parametrize("value", ["high", "[1]", "NaN", "", "true", "1e999"])
@one_kind
def test_properties_that_are_no_calibration_are_passed_over(database: Database, value: str) -> None:
    (uuid,) = store(database, {"a.bvh": bvh(9, names=NAMES)})
    with database.write("a") as tx:
        (before,) = read_bodies(tx, listed(tx)).values()
        properties = [("calibration floor", value or "?", ""), ("calibration of cameras", "2", "")]
        change_document(tx, tx.documents.get(uuid), properties=properties)
    with database.read() as tx:
        (after,) = read_bodies(tx, listed(tx)).values()
        assert same(before, after)


@pytest.mark.parametrize(
    ("frames", "joints"),
    [(0, 0), (0, 3), (1, 1), (300, 5), (packed_positions.BLOCK, 1), (packed_positions.BLOCK + 1, 2)],
)
def test_steps_come_back(frames: int, joints: int) -> None:
    rng = np.random.default_rng(1)
    made = rng.integers(-(2**31) + 1, 2**31 - 1, (frames, joints, 3)).astype(np.int32)
    made[rng.random((frames, joints)) < 0.1] = UNSEEN
    blocks = tuple(packed_positions.pack(made))
    for joint in range(joints):
        assert np.array_equal(packed_positions.unpack(blocks, [joint])[0], made[:, joint])


CHANGES: Sequence[Callable[[bytes], bytes]] = (
    lambda data: data[:-3],
    lambda data: data[:5],
    lambda data: b"\xff" * 12 + data[12:],
    lambda data: data[:12] + b"\xff\xff\xff\x7f" + data[16:],
    lambda _: b"",
)


@pytest.mark.parametrize("change", CHANGES)
def test_damaged_steps_are_an_error(change: Any) -> None:
    (block,) = packed_positions.pack(np.arange(600, dtype=np.int32).reshape(20, 10, 3))
    with pytest.raises(StoreError):
        packed_positions.unpack((change(block),), range(10))
