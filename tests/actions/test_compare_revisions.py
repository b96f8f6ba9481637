"""Differences of revisions, against those of their frames read whole."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from fastapi.testclient import TestClient
from scipy.spatial.transform import Rotation

from mcml.motion.skeleton import CHANNELS
from mcml_service.actions.editing.frame_ranges import delete_frames, insert_frames, write_values
from mcml_service.actions.editing.single_element import Change
from mcml_service.actions.editing.whole_document import add_labels, change_document
from mcml_service.actions.reading.compare_revisions import compare_revisions
from mcml_service.clips.read_clip import read_clip
from mcml_service.operations.arguments import at_revision
from mcml_service.storage.database import Database
from tests.builders import bvh, store
from tests.edits import change_element


def whole(database: Database, uuid: str, revision: int) -> tuple[np.ndarray, list[str]]:
    with database.read() as tx:
        then, stored = at_revision(tx, uuid, revision)
        clip = read_clip(then, stored)
        columns = [f"{clip.names[joint]}.{CHANNELS[channel]}" for joint, channel in clip.clip.head.skeleton.columns()]
        return np.concatenate([block.values for block in clip.clip.blocks()]), columns


@pytest.mark.parametrize("seed", range(4))
def test_random_changes_are_found(database: Database, seed: int) -> None:
    chance = Random(seed)
    uuid = store(database, {"a.bvh": bvh(900, seed=seed)}, labels=())[0]
    dropped: list[int] = []
    for _ in range(8):
        with database.write() as tx:
            stored = tx.documents.get(uuid)
            first = chance.randint(1, stored.frames - 40)
            what = chance.randrange(4)
            if what == 0:
                delete_frames(tx, stored, first, first + 20)
                kept = [n for n in range(900) if n not in dropped]
                dropped += kept[first - 1 : first + 20]
            elif what == 1:
                write_values(tx, stored, first, [("Spine", "Rx")], np.full((30, 1), chance.random()))
            elif what == 2:
                change_element(tx, stored, f"/mcml/motion/frame[{first}]/frame_bone[1]", Change({"Tx": "99.5"}))
            else:
                add_labels(tx, stored, [("hop", first, first + 5)])
            if what < 2:
                tx.documents.add_revision(stored, "frames", "x")
    last = 9
    with database.read() as tx:
        (then, one), (now, other) = at_revision(tx, uuid, 1), at_revision(tx, uuid, None)
        assert other.revision == last
        found = compare_revisions(then, one, now, other)
        labels = {(span.name, span.first, span.last) for span in now.spans.of(other.key)}
    old, columns = whole(database, uuid, 1)
    new, _ = whole(database, uuid, last)
    kept = [n for n in range(900) if n not in dropped]
    removed = [n for part in found.frames_removed for n in range(part.first - 1, part.last)]
    assert removed == sorted(dropped)
    assert found.frames_added == []
    assert not found.frames_moved
    both = [(run.before + at, run.after + at) for run in found.frames_kept for at in range(run.count)]
    assert both == [(before + 1, after + 1) for after, before in enumerate(kept)]
    assert len(found.frames_kept) <= len(found.frames_removed) + 1
    assert {(item.name, item.first, item.last) for item in found.labels_added} == labels
    differs = old[kept] != new
    expected = {}
    for bone in ("Root", "Spine", "Head"):
        mine = [i for i, name in enumerate(columns) if name.startswith(f"{bone}.")]
        rows = np.flatnonzero(differs[:, mine].any(axis=1))
        if not len(rows):
            continue
        sizes = np.abs(old[kept] - new)[rows][:, mine].max(axis=0)
        turns = [mine[[columns[i] for i in mine].index(f"{bone}.R{axis}")] for axis in "zxy"]
        a, b = (Rotation.from_euler("ZXY", table[rows][:, turns], degrees=True) for table in (old[kept], new))
        expected[bone] = (
            rows[0] + 1, rows[-1] + 1, len(rows),
            {columns[i].split(".")[1]: size for i, size in zip(mine, sizes, strict=True) if size},
            np.degrees((a.inv() * b).magnitude()).max(),
        )  # fmt: skip
    assert {item.bone: (item.first, item.last, item.frames) for item in found.bones} == {
        bone: item[:3] for bone, item in expected.items()
    }
    for item in found.bones:
        assert item.channels == pytest.approx(expected[item.bone][3])
        assert item.angle == pytest.approx(expected[item.bone][4], abs=1e-5)


def test_head_and_frames_that_came(database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(20)})[0]
    with database.write() as tx:
        change_document(tx, tx.documents.get(uuid), unit="cm")
    with database.write() as tx:
        stored = tx.documents.get(uuid)
        insert_frames(tx, stored, 6, stored, 1, 3)
        tx.documents.add_revision(stored, "frames", "x")
    with database.read() as tx:
        (then, one), (now, other) = at_revision(tx, uuid, 1), at_revision(tx, uuid, None)
        found = compare_revisions(then, one, now, other)
    assert [(item.first, item.last) for item in found.frames_added] == [(6, 8)]
    assert found.bones == []
    assert [(item.address, item.before, item.after) for item in found.elements] == [
        ("/mcml/header/calibration_unit", None, "cm")
    ]


def test_over_http(client: TestClient) -> None:
    uuid = client.post("/api/v1/documents", files=[("file", ("a.bvh", bvh(20)))]).json()["documents"][0]["id"]
    url = f"/api/v1/documents/{uuid}"
    body = {"attributes": {"Rx": "45"}}
    address = {"xpath": "/mcml/motion/frame[5]/frame_bone[2]"}
    client.patch(f"{url}/elements", params=address, json=body, headers={"if-match": "*"})
    found = client.get(f"{url}/difference", params={"before": 1}).json()
    assert (found["before"], found["after"]) == (1, 2)
    assert [(item["bone"], item["first"], item["frames"]) for item in found["bones"]] == [("Spine", 5, 1)]
    assert found["bones"][0]["angle"] > 1
    same = client.get(f"{url}/difference", params={"before": 2, "after": 2}).json()
    assert same["bones"] == same["elements"] == []
    assert client.get(f"{url}/difference", params={"before": 9}).status_code == 404
