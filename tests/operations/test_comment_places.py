"""Comments at frames, where these are in later revisions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, store

pytestmark = pytest.mark.above_store

API = "/api/v1/documents"


class Edited:
    """A document whose frames have numbers of the test's own, by revision."""

    def __init__(self, client: TestClient, uuid: str, frames: int) -> None:
        self._client, self._uuid = client, uuid
        self.past = [list(range(frames))]
        self._new = frames

    @property
    def now(self) -> list[int]:
        return self.past[-1]

    def send(self, path: str, body: object = None, **query: object) -> None:
        match = {"If-Match": f'"{len(self.past)}"'}
        answer = self._client.post(f"{API}/{self._uuid}/{path}", json=body, params=query, headers=match)
        assert answer.status_code == 200, answer.text

    def frames(self, then: list[int], **edit: object) -> None:
        self.send("frames", {"edits": [edit]})
        self.past.append(then)

    def change_at_random(self, kind: str, random: np.random.Generator) -> None:
        quarter = len(self.now) // 4
        first = int(random.integers(1, quarter + 2))
        last = first + int(random.integers(2 * quarter, 3 * quarter) if kind == "keep" else random.integers(quarter))
        part, before, after = self.now[first - 1 : last], self.now[: first - 1], self.now[last:]
        if kind == "undo":
            self.send("undo", revision=len(self.past))
            self.past.append(self.past[-2])
        elif kind == "restore":
            number = int(random.integers(1, len(self.past) + 1))
            self.send("restore", revision=number)
            self.past.append(self.past[number - 1])
        elif kind == "insert":
            copies = list(range(self._new, self._new + len(part)))
            self._new += len(part)
            self.frames(copies + self.now, do="insert", at=1, first=first, last=last)
        else:
            self.frames(part if kind == "keep" else before + after, do=kind, first=first, last=last)

    def comment(self, first: int, last: int) -> None:
        body = {"text": "look", "first": first, "last": last}
        assert self._client.post(f"{API}/{self._uuid}/comments", json=body).status_code == 201

    def comments(self) -> list[dict[str, Any]]:
        items: list[dict[str, Any]] = self._client.get(f"{API}/{self._uuid}/comments").json()["items"]
        return items


def test_comments_follow_their_frames(client: TestClient, database: Database) -> None:
    edited = Edited(client, store(database, {"walk.bvh": bvh(60)})[0], 60)
    random = np.random.default_rng(3)
    for kind in ("delete", "keep", "insert", "undo", "restore") * 5:
        first = int(random.integers(1, len(edited.now) + 1))
        edited.comment(first, min(len(edited.now), first + int(random.integers(3))))
        edited.change_at_random(kind, random)
    left = 0
    for found in edited.comments():
        meant = edited.past[found["revision"] - 1][found["first"] - 1 : found["last"]]
        places = [place + 1 for place, frame in enumerate(edited.now) if frame in meant]
        assert (found["first_now"], found["last_now"]) == ((min(places), max(places)) if places else (None, None))
        left += bool(places)
    assert 5 < left < 25, "some frames are left, others are gone"


def test_replaced_samples_are_the_same_frames(client: TestClient, database: Database) -> None:
    edited = Edited(client, store(database, {"walk.bvh": bvh(60)})[0], 60)
    edited.comment(30, 32)
    edited.frames(edited.now, do="smooth", first=1, last=60)
    edited.frames(edited.now[10:], do="delete", first=1, last=10)
    (found,) = edited.comments()
    assert (found["revision"], found["first"], found["first_now"], found["last_now"]) == (1, 30, 20, 22)
