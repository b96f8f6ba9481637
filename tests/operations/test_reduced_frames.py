"""Least and greatest samples of stretches: the same from zone maps as from the samples themselves."""

from __future__ import annotations

import io

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml.motion.skeleton import Array
from mcml_service.actions.reading import reduce_frames
from mcml_service.storage.database import Database
from tests import fuzz
from tests.builders import TRC, bvh, one_kind, store

pytestmark = pytest.mark.above_store

API = "/api/v1/documents"


def samples(client: TestClient, uuid: str, **asked: object) -> tuple[Array, int]:
    answer = client.get(f"{API}/{uuid}/frames", params={"format": "npy", **asked})  # type: ignore[arg-type]
    assert answer.status_code == 200, answer.text
    return np.load(io.BytesIO(answer.content)), int(answer.headers.get("x-mcml-step", 0))


def obvious(values: Array, step: int) -> Array:
    rows = [values[start : start + step] for start in range(0, len(values), step)]
    with np.errstate(all="ignore"):
        return np.array([[np.fmin.reduce(row), np.fmax.reduce(row)] for row in rows]).transpose(0, 2, 1)


@pytest.mark.parametrize("asked", [{}, {"first": 257}, {"first": 100, "last": 2600}, {"bone": "Spine"}, {"last": 1024}])
@pytest.mark.parametrize("pixels", fuzz.share([1, 3, 7, 40, 100_000], 2))
def test_extremes_are_those_of_the_samples(database: Database, pixels: int, asked: dict[str, object]) -> None:
    from tests.builders import served

    with served(database) as client:
        uuid = store(database, {"walk.bvh": bvh(2700)})[0]
        assert client.post(
            f"{API}/{uuid}/frames",
            json={"edits": [{"do": "delete", "first": 1300, "last": 1310}], "renumber": True},
            headers={"if-match": "*"},
        ).is_success
        for revision in (1, 2):
            whole, _ = samples(client, uuid, revision=revision, **asked)
            found, step = samples(client, uuid, reduce="minmax", pixels=pixels, revision=revision, **asked)
            assert len(found) <= pixels
            np.testing.assert_array_equal(found, obvious(whole, step))


def test_zone_maps_are_enough_for_long_stretches(client: TestClient, database: Database) -> None:
    uuid = store(database, {"walk.bvh": bvh(3000)})[0]
    whole, _ = samples(client, uuid)
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        # Whatever unpacks a track fails.
        tx.tracks.blocks = None  # type: ignore[method-assign, assignment]
        found = reduce_frames.reduce_frames(tx, stored, 1, None, 10, None)
    assert (found.step, found.values.shape) == (512, (6, 12, 2))
    np.testing.assert_array_equal(found.values, obvious(whole, 512))


def test_stretches_without_samples_are_nan(client: TestClient, database: Database) -> None:
    uuid = store(database, {"hand.trc": TRC})[0]
    found, step = samples(client, uuid, reduce="minmax", pixels=4)
    assert step == 1
    assert np.argwhere(np.isnan(found[:, ::3, 0])).tolist() == [[1, 1], [2, 0], [3, 2]]
    assert not np.isnan(samples(client, uuid, reduce="minmax", pixels=1)[0]).any()


@pytest.mark.parametrize("asked", [{"space": "positions"}, {"format": "npz"}, {"format": "json"}, {"step": 2}])
@one_kind
def test_only_channels_have_extremes(client: TestClient, database: Database, asked: dict[str, object]) -> None:
    uuid = store(database, {"walk.bvh": bvh(3)})[0]
    query = {"reduce": "minmax", "format": "block", **asked}
    assert client.get(f"{API}/{uuid}/frames", params=query).status_code == 422  # type: ignore[arg-type]
    none = store(database, {"none.bvh": bvh(0)})[0]
    assert samples(client, none, reduce="minmax")[0].shape == (0, 12, 2)
