"""Undo: after any edit the identity; of an earlier edit, as if it had not been; refused where later ones touched it."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.errors import ConflictError, McmlError
from mcml_service.actions.editing.frame_ranges import (
    delete_frames,
    insert_frames,
    move_frames,
    reverse,
    trim,
    write_values,
)
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, change_document, remove_labels, undo_revision
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction
from tests.actions.test_frame_ranges import content
from tests.builders import bvh, store
from tests.edits import OTHER_SEEDS, change_element, delete_element


def edit(tx: Transaction, stored: StoredDocument, chance: Random) -> None:
    """One random edit of any kind, as a revision."""
    count = stored.frames
    # The last frame may be gone: then what touches frames is refused.
    first = chance.randint(1, max(1, count))
    last = min(count, first + chance.choice([0, 3, 60]))
    what = chance.randrange(11)
    if what == 0:
        change_element(tx, stored, f"/mcml/motion/frame[{first}]/frame_bone[2]", Change({"Rx": repr(chance.random())}))
    elif what == 1:
        delete_element(tx, stored, f"/mcml/motion/frame[{first}]")
    elif what == 2:
        change_element(tx, stored, f"/mcml/motion/frame[{first}]", Change({"id": chance.choice(["a", "7"])}))
    elif what == 3:
        change_element(tx, stored, "/mcml/skeleton/bone/name", Change({}, chance.choice(["tail", "trunk"])))
    elif what == 4:
        change_document(tx, stored, description=chance.choice(["a", "b", ""]), unit=chance.choice(["cm", "m"]))
    elif what == 5:
        change_document(tx, stored, name=f"n{chance.random()}", frame_time=chance.choice(["0.01", "0.02"]))
    elif what == 6:
        add_labels(tx, stored, [(chance.choice(["hop", "run"]), first, last)])
    elif what == 7 and (spans := tx.spans.of(stored.key)):
        remove_labels(tx, stored, chance.choice(spans).key)
    else:
        other = chance.choice([delete_frames, trim, reverse])
        if what == 8:
            insert_frames(tx, stored, first, stored, 1, min(count, 5))
        elif what == 9:
            move_frames(tx, stored, first, last, chance.randint(1, count + 1), renumber=True)
        elif what == 10:
            write_values(tx, stored, first, [("Root", "Tx")], np.array([[chance.random()]]))
        else:
            other(tx, stored, first, last)
        tx.documents.add_revision(stored, "frames", "frames")


def undone_at_random(database: Database, seed: int, steps: int) -> None:
    chance = Random(seed)
    uuid = store(database, {"a.bvh": bvh(chance.choice([4, 300, 600]), seed=seed)}, labels=())[0]
    taken = refused = 0
    for _ in range(steps):
        before = content(database, uuid)
        with database.read() as tx:
            name = tx.documents.get(uuid).name
        try:
            with database.write() as tx:
                edit(tx, tx.documents.get(uuid), chance)
        except McmlError:
            continue
        after = content(database, uuid)
        with database.read() as tx:
            made = tx.documents.get(uuid).revision
        if chance.random() < 0.6:
            with database.write() as tx:
                undo_revision(tx, tx.documents.get(uuid), made)
            assert content(database, uuid) == before
            with database.read() as tx:
                assert tx.documents.get(uuid).name == name
            taken += 1
            if chance.random() < 0.5:
                with database.write() as tx:
                    undo_revision(tx, tx.documents.get(uuid), made + 1)
                assert content(database, uuid) == after
        elif made > 3:
            # Some earlier revision: taken back soundly, or refused and nothing changed.
            try:
                with database.write() as tx:
                    undo_revision(tx, tx.documents.get(uuid), chance.randint(2, made - 1))
                taken += 1
            except ConflictError:
                refused += 1
                assert content(database, uuid) == after
        assert database.check() == []
    assert taken > steps // 8


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:2], indirect=["kind"])
def test_random_undo(database: Database, seed: int) -> None:
    undone_at_random(database, seed, 20)


@pytest.mark.fuzz(seeds=50)
def test_random_undo_many_times(database: Database, seed: int) -> None:
    undone_at_random(database, seed, 100)


def test_an_earlier_edit_is_taken_back_alone(client: TestClient) -> None:
    uuid = client.post("/api/v1/documents", files=[("file", ("a.bvh", bvh(600)))]).json()["documents"][0]["id"]
    url, one = f"/api/v1/documents/{uuid}", "/mcml/motion/frame[5]/frame_bone[2]"
    two = "/mcml/motion/frame[500]/frame_bone[2]"
    original = client.get(f"{url}/mcml").content
    anything = {"if-match": "*"}

    def set_rx(address: str, value: str) -> None:
        body = {"attributes": {"Rx": value}}
        assert (
            client.patch(f"{url}/elements", params={"xpath": address}, json=body, headers=anything).status_code == 200
        )

    set_rx(one, "1.25")
    set_rx(two, "2.5")
    answer = client.post(f"{url}/undo", params={"revision": 2}, headers={"if-match": '"3"'})
    assert answer.status_code == 200, answer.text
    assert answer.json()["revision"] == 4
    value = client.get("/api/v1/xpath", params={"q": f"string({two}/@Rx)"}).json()["value"]
    assert value == "2.5"
    assert client.post(f"{url}/undo", params={"revision": 3}, headers=anything).status_code == 200
    assert client.get(f"{url}/mcml").content == original
    set_rx(one, "3.5")
    set_rx(one, "4.5")
    refused = client.post(f"{url}/undo", params={"revision": 6}, headers=anything)
    assert refused.status_code == 409
    assert "since" in refused.json()["detail"]
    assert client.post(f"{url}/undo", params={"revision": 1}, headers=anything).status_code == 409
    assert client.post(f"{url}/undo", params={"revision": 99}, headers=anything).status_code == 404
    assert client.post(f"{url}/undo").status_code == 428
    # Without saying which, the last one.
    client.post(f"{url}/undo", headers=anything)
    assert client.get("/api/v1/xpath", params={"q": f"string({one}/@Rx)"}).json()["value"] == "3.5"


def test_names_of_frames_that_moved_are_not_put_on_others(database: Database) -> None:
    """A name that was taken away comes back where it was: not if frames before it have gone since."""
    uuid = store(database, {"a.bvh": bvh(30)}, labels=())[0]
    with database.write() as tx:
        (span,) = add_labels(tx, tx.documents.get(uuid), [("hop", 10, 20)])
    with database.write() as tx:
        remove_labels(tx, tx.documents.get(uuid), span.key)
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        delete_frames(tx, stored, 1, 5)
        tx.documents.add_revision(stored, "frames", "cut")
    before = content(database, uuid)
    with pytest.raises(ConflictError, match="frames came or went"), database.write() as tx:
        undo_revision(tx, tx.documents.get(uuid), 3)
    assert content(database, uuid) == before
    for number in (4, 3):
        with database.write() as tx:
            undo_revision(tx, tx.documents.get(uuid), number)
    with database.read() as tx:
        assert [(span.name, span.first, span.last) for span in tx.spans.of(tx.documents.get(uuid).key)] == [
            ("hop", 10, 20)
        ]


def samples(database: Database, uuid: str) -> dict[tuple[int, int, int], float]:
    """Every sample of a document by frame, bone and channel."""
    found = {}
    with database.read() as tx:
        stored, frame = tx.documents.get(uuid), 0
        for block in tx.tracks.blocks(stored.key, 1, stored.frames):
            for row in block.values.tolist():
                frame += 1
                found |= {
                    (frame, *column): value for column, value in zip(block.columns, row, strict=True) if value == value
                }
    return found


@pytest.mark.parametrize("seed", range(4))
def test_samples_of_one_track_are_taken_back_apart(database: Database, seed: int) -> None:
    """Edits of attributes of a few frames of two bones, taken back in any order: against a dictionary of samples."""
    chance = Random(seed)
    uuid = store(database, {"a.bvh": bvh(300)}, labels=())[0]
    states = [samples(database, uuid)]
    for _ in range(14):
        # Frames on both sides of the end of a track, values that may be the same, attributes that come and go.
        address = f"/mcml/motion/frame[{chance.choice([1, 2, 3, 256, 257])}]/frame_bone[{chance.choice([2, 3])}]"
        text = chance.choice(["1.5", "2.5", None])
        with database.write() as tx:
            try:
                change_element(tx, tx.documents.get(uuid), address, Change({chance.choice(["Rx", "Rz", "Tx"]): text}))
            except McmlError:
                continue
        states.append(samples(database, uuid))
    taken = refused = 0
    for number in chance.sample(range(2, len(states) + 1), len(states) - 1):
        before, after, now = states[number - 2], states[number - 1], samples(database, uuid)
        changed = {key for key in before.keys() | after.keys() if before.get(key) != after.get(key)}
        allowed = all(now.get(key) == after.get(key) for key in changed)
        try:
            with database.write() as tx:
                undo_revision(tx, tx.documents.get(uuid), number)
        except ConflictError:
            assert not allowed, number
            assert samples(database, uuid) == now
            refused += 1
            continue
        assert allowed, number
        expected = {key: value for key, value in now.items() if key not in changed}
        assert samples(database, uuid) == expected | {key: before[key] for key in changed if key in before}
        taken += 1
    assert taken > 4
    assert database.check() == []
