"""Bodies of long documents, of which some frames at a time are in memory, are those of short ones."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fastapi.testclient import TestClient

from mcml.motion.bodies import clip_body
from mcml.motion.bodies.activities.recognition import recognize_activities
from mcml.motion.bodies.activities.signals import JOINTS
from mcml_service.clips import bodies
from mcml_service.storage.database import Database
from mcml_service.storage.documents import packed_positions
from tests.builders import bvh, one_kind, store
from tests.motion.bodies.made import person
from tests.odd_documents import ODD

pytestmark = one_kind


@pytest.mark.slow
@pytest.mark.parametrize("reference", ["1", "597", None])
def test_what_is_derived_in_parts_is_the_same(
    client: TestClient, database: Database, monkeypatch: pytest.MonkeyPatch, reference: str | None
) -> None:
    long = [{"walk.bvh": person(3, 600)}, {"turn.bvh": person(8, 333)}, {"chain.bvh": bvh(700)}]
    kinds = [ODD[kind] for kind in ("seen by turns", "seen late", "one joint", "no frames", "many markers")]
    uuids = [uuid for files in (*long, *kinds) for uuid in store(database, files)]
    if reference is not None:
        change = {"json": {"reference": reference}, "headers": {"if-match": "*"}}
        assert client.patch(f"/api/v1/documents/{uuids[0]}/calibration", **change).status_code == 200
    # A block holds as many frames in both ways, and ends elsewhere than what is read at a time.
    monkeypatch.setattr(packed_positions, "BLOCK", 150)
    with database.read() as tx:
        whole = list(bodies.derive_bodies(tx, tx.columns.documents(), {}))
    monkeypatch.setattr(bodies, "LONG", 20)
    monkeypatch.setattr(bodies, "FRAMES_TOGETHER", 20)
    monkeypatch.setattr(clip_body, "FRAMES_TOGETHER", 64)
    with database.read() as tx:
        parts = list(bodies.derive_bodies(tx, tx.columns.documents(), {}))
    # Activities of long documents are found when they are asked for.
    assert {body.frames > 20: body.activities is None for body in parts} == {True: True, False: False}
    assert [recognize_activities(body.stretch(JOINTS)) for body in parts] == [body.activities for body in whole]
    parts, whole = ([replace(body, activities=None) for body in each] for each in (parts, whole))
    assert [(body.facts(), body.blocks) for body in parts] == [(body.facts(), body.blocks) for body in whole]
    assert max(len(body.blocks) for body in whole) > 3
