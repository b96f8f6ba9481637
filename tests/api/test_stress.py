"""Many clients at once, on both databases: no 500, no lost update, gapless revisions, and nothing half stored."""

from __future__ import annotations

import io
import random
import zipfile
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from fastapi.testclient import TestClient

from mcml_service.storage.database import Database
from tests.builders import ASF, amc, bvh, store, upload

API = "/api/v1"
THREADS = 8


def at_once(calls: list[Any]) -> list[Any]:
    with ThreadPoolExecutor(THREADS) as pool:
        return [job.result() for job in [pool.submit(call) for call in calls]]


def test_the_same_new_things_at_once(client: TestClient, database: Database) -> None:
    """Project, skeleton and files are new and equal in every request."""

    def send(number: int) -> Any:
        files = [("file", ("leg.asf", ASF)), ("file", ("leg.amc", amc(2 + number % 2))), ("file", ("a.bvh", bvh(20)))]
        return client.post(f"{API}/documents", files=files, data={"project": "new", "label": "walk"})

    answers = at_once([lambda number=number: send(number) for number in range(2 * THREADS)])
    assert {answer.status_code for answer in answers} == {201}
    assert all(len(answer.json()["documents"]) == 2 and not answer.json()["problems"] for answer in answers)
    assert client.get(f"{API}/documents?project=new").json()["total"] == 4 * THREADS
    assert client.get(f"{API}/projects").json()["items"] == ["new"]
    assert len(client.get(f"{API}/skeletons").json()["items"]) == 2
    assert database.check() == []


def test_equal_files_at_once_are_skipped(client: TestClient, database: Database) -> None:
    file = [("file", ("a.bvh", bvh(20)))]
    answers = at_once(
        [lambda: client.post(f"{API}/documents", files=file, data={"on_duplicate": "skip"}) for _ in range(THREADS)]
    )
    assert {answer.status_code for answer in answers} == {201}
    assert len({answer.json()["documents"][0]["id"] for answer in answers}) == 1
    assert sum(not answer.json()["documents"][0]["skipped"] for answer in answers) == 1
    assert database.sweep(lease_before=float("inf")) == 0


def test_no_update_is_lost(client: TestClient, database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(600)})[0]
    address, chance = f"{API}/documents/{uuid}", random.Random(3)

    def label(number: int, tag: str) -> Any:
        body = [{"name": f"name-{number}", "first": chance.randint(1, 300), "last": chance.randint(300, 600)}]
        return client.post(f"{address}/labels", json=body, headers={"if-match": tag})

    def read(_: int) -> Any:
        page = client.get(f"{API}/xpath", params={"q": "//frame[motion_name]", "as": "runs", "document": uuid})
        content = client.get(f"{address}/mcml")
        assert content.content.endswith(b"</mcml>\n")
        return page

    jobs = [lambda n=n: label(n, "*") for n in range(24)] + [lambda n=n: read(n) for n in range(8)]
    chance.shuffle(jobs)
    answers = at_once(jobs)
    assert {answer.status_code for answer in answers} <= {200, 201}
    numbers = [item["number"] for item in client.get(f"{address}/revisions").json()["items"]]
    assert numbers == list(range(25, 0, -1))
    assert {item["name"] for item in client.get(f"{address}/labels").json()["items"]} == {
        f"name-{n}" for n in range(24)
    }
    # With the revision that all have read, one wins.
    answers = at_once([lambda n=n: label(100 + n, '"25"') for n in range(THREADS)])
    assert sorted(answer.status_code for answer in answers) == [201] + [412] * (THREADS - 1)
    assert database.check() == []


def test_deletes_moves_and_restores_at_once(client: TestClient, database: Database) -> None:
    uuid = store(database, {"a.bvh": bvh(20)})[0]
    address, head = f"{API}/documents/{uuid}", {"if-match": "*"}
    calls = []
    for number in range(8):
        calls += [
            lambda: client.delete(address, headers=head),
            lambda: client.post(f"{address}/restore", headers=head),
            lambda: client.post(f"{address}/restore?revision=1", headers=head),
            lambda n=number: client.patch(address, json={"project": f"p{n % 3}", "unit": "cm"}, headers=head),
            lambda: client.get(address),
        ]
    random.Random(4).shuffle(calls)
    answers = at_once(calls)
    assert {answer.status_code for answer in answers} <= {200, 204, 404, 409, 412}
    client.post(f"{address}/restore", headers=head)
    numbers = [item["number"] for item in client.get(f"{address}/revisions").json()["items"]]
    assert numbers == list(range(len(numbers), 0, -1))
    assert database.check() == []


def test_a_deleted_twin_is_no_twin(client: TestClient) -> None:
    first = upload(client, {"a.bvh": bvh(4)})["documents"][0]["id"]  # type: ignore[index]
    client.delete(f"{API}/documents/{first}", headers={"if-match": "*"})
    again = upload(client, {"a.bvh": bvh(4)}, on_duplicate="skip")["documents"][0]  # type: ignore[index]
    assert (again["skipped"], again["receipt"]["twins"]) == (False, [])


def test_part_of_the_files_is_no_twin(client: TestClient) -> None:
    upload(client, {"leg.asf": ASF, "leg.amc": amc(2)})
    alone = upload(client, {"leg.asf": ASF}, on_duplicate="skip")["documents"][0]  # type: ignore[index]
    assert (alone["skipped"], alone["receipt"]["frames"]) == (False, 0)


def test_a_broken_zip_is_a_problem(client: TestClient) -> None:
    chance = random.Random(5)
    for method in (zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA, zipfile.ZIP_STORED):
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", method) as archive:
            archive.writestr("걸음.bvh", bvh(40))
        whole = buffer.getvalue()
        broken = [whole.replace("걸음".encode(), b"\xff\xfe\xff\xfe\xff\xfe")]
        for _ in range(25):
            content = bytearray(whole)
            for _ in range(chance.randint(1, 4)):
                content[chance.choice([chance.randrange(len(content)), -1 - chance.randrange(90)])] = chance.randrange(
                    256
                )
            broken.append(bytes(content))
        for content in broken:
            answer = client.post(f"{API}/documents", files=[("file", ("x.zip", bytes(content)))])
            assert answer.status_code in (201, 415, 422), answer.text
