"""32 writers on one document: no update is lost, nobody waits for ever, the history is complete and without gaps."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from random import Random
from threading import Lock
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import bvh, store

API = "/api/v1"
WRITERS = 32
COMMON = "/mcml/motion/frame[1]/frame_bone[2]"
"""What all writers count up, each from what it read."""


class Writer:
    """Counts a value of its own and one of all up, names frames, adjusts a channel, takes its own edits back."""

    def __init__(self, client: TestClient, uuid: str, number: int) -> None:
        self._client, self._url, self._number = client, f"{API}/documents/{uuid}", number
        self._chance = Random(number)
        self.own = f"/mcml/motion/frame[{10 + number}]/frame_bone[2]"
        self.done: Counter[str] = Counter()
        self.statuses: Counter[int] = Counter()
        self.revisions: list[int] = []

    def run(self, more: Callable[[], bool]) -> None:
        while more():
            what = self._chance.choice([self.count_own, self.count_own, self.count_common, self.name, self.adjust])
            what()

    def count_own(self) -> None:
        """Somebody else's edits meanwhile are no conflict: they are merged."""
        self._count(self.own, "own", merge=True)

    def count_common(self) -> None:
        self._count(COMMON, "common", merge=self._chance.random() < 0.5)

    def _count(self, address: str, kind: str, merge: bool) -> None:
        element = self._client.get(f"{self._url}/elements", params={"xpath": f"{address}/@Rx"})
        body = {"attributes": {"Rx": str(float(element.text) + 1)}}
        # The revision that was read decides who wins, and a merge looks at the element alone.
        head = {"if-match": f'"{element.headers["etag"].strip(chr(34)).split("-")[0]}"'}
        asked = {"xpath": address, "merge": merge}
        answer = self._client.patch(f"{self._url}/elements", json=body, params=asked, headers=head)
        self._note(answer, kind, {200, 409, 412})
        if merge and kind == "own":
            assert answer.status_code == 200, answer.text

    def name(self) -> None:
        body = [{"name": f"writer-{self._number}", "first": 10 + self._number, "last": 200}]
        self._note(self._client.post(f"{self._url}/labels", json=body, headers={"if-match": "*"}), "label", {201})

    def adjust(self) -> None:
        edit = {"do": "adjust", "first": 100, "last": 300, "channels": ["Rz"], "offset": 1.0, "bones": ["Spine"]}
        answer = self._client.post(f"{self._url}/frames", json={"edits": [edit]}, headers={"if-match": "*"})
        self._note(answer, "adjust", {200})

    def _note(self, answer: Any, kind: str, allowed: set[int]) -> None:
        assert answer.status_code in allowed, answer.text
        self.statuses[answer.status_code] += 1
        if answer.is_success:
            self.done[kind] += 1
            tag = answer.headers.get("etag", "")
            self.revisions.append(int(tag.strip('"').split("-")[0]))


def value(client: TestClient, uuid: str, address: str, channel: str) -> float:
    answer = client.get(f"{API}/documents/{uuid}/elements", params={"xpath": f"{address}/@{channel}"})
    return float(answer.text)


def check(client: TestClient, database: Database, more: Callable[[], Callable[[], bool]]) -> int:
    """Let writers write; answers how many edits they made."""
    uuid = store(database, {"a.bvh": bvh(400)})[0]
    for address in (COMMON, *(f"/mcml/motion/frame[{10 + number}]/frame_bone[2]" for number in range(WRITERS))):
        body, head = {"attributes": {"Rx": "0"}}, {"if-match": "*"}
        client.patch(f"{API}/documents/{uuid}/elements", json=body, params={"xpath": address}, headers=head)
    before = value(client, uuid, "/mcml/motion/frame[150]/frame_bone[2]", "Rz")
    start = client.get(f"{API}/documents/{uuid}").json()["revision"]
    writers = [Writer(client, uuid, number) for number in range(WRITERS)]
    with ThreadPoolExecutor(WRITERS) as pool:
        for job in [pool.submit(writer.run, more()) for writer in writers]:
            job.result()
    total = sum((writer.done for writer in writers), Counter[str]())
    assert value(client, uuid, COMMON, "Rx") == total["common"]
    assert [value(client, uuid, writer.own, "Rx") for writer in writers] == [w.done["own"] for w in writers]
    after = value(client, uuid, "/mcml/motion/frame[150]/frame_bone[2]", "Rz")
    assert after == pytest.approx(before + total["adjust"])
    made = sorted(revision for writer in writers for revision in writer.revisions)
    assert made == list(range(start + 1, start + 1 + total.total())), (
        "every edit is one revision, and no other is there"
    )
    with database.read() as tx:
        stored = tx.documents.get(uuid)
        history = [item.number for item in tx.revisions.of(stored.key, before=None, limit=10**6)]
        spans = Counter(span.name for span in tx.spans.of(stored.key))
    assert history == list(range(start + total.total(), 0, -1))
    assert spans == Counter({f"writer-{n}": writer.done["label"] for n, writer in enumerate(writers)}) + Counter()
    assert database.check() == []
    return total.total()


def times(number: int) -> Callable[[], bool]:
    left, lock = [number], Lock()

    def more() -> bool:
        with lock:
            left[0] -= 1
            return left[0] >= 0

    return more


@pytest.mark.slow
def test_writers_on_one_document(client: TestClient, database: Database) -> None:
    assert check(client, database, lambda: times(2)) > WRITERS


@pytest.mark.fuzz
def test_writers_on_one_document_for_a_minute(client: TestClient, database: Database) -> None:
    end = time.monotonic() + 60
    print(check(client, database, lambda: lambda: time.monotonic() < end), "edits")
