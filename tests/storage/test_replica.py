"""A real streaming replica: who wrote sees it at once, however far behind it is, and nobody notices when it dies."""

from __future__ import annotations

import logging
import random
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st

from mcml.errors import ReplicaError, StoreError
from mcml_service.api import streaming
from mcml_service.settings import Settings
from mcml_service.storage.core import replica as replicas
from mcml_service.storage.core.replica import Snapshot
from mcml_service.storage.database import Database
from mcml_service.storage.documents.documents import Documents
from mcml_service.storage.transaction import Transaction
from tests import postgres
from tests.builders import bvh, served, upload

FRAMES = 5000


@pytest.fixture(scope="module")
def primary(postgres_template: str) -> Iterator[str]:
    with postgres.new_database(postgres_template, "template_store") as url:
        yield url


@pytest.fixture(scope="module")
def replica(primary: str) -> Iterator[postgres.Replica]:
    with postgres.replica(primary) as made:
        yield made


@pytest.fixture
def read_again(monkeypatch: pytest.MonkeyPatch, replica: postgres.Replica) -> Iterator[None]:
    """One that was away is tried again at once; it is there in the end."""
    monkeypatch.setattr(replicas, "AWAY_SECONDS", 0.0)
    yield
    replica.start()


@pytest.fixture
def stores(primary: str, replica: postgres.Replica) -> Iterator[list[Database]]:
    """Two servers' stores."""
    made = [Database(primary, replica.url) for _ in range(2)]
    yield made
    for one in made:
        one.close()


@pytest.fixture
def clients(stores: list[Database]) -> Iterator[list[TestClient]]:
    first, second = map(served, stores)
    with first, second:
        yield [first, second]


def uuid_of(client: TestClient, files: dict[str, bytes]) -> str:
    found: Any = upload(client, files, project="lab")["documents"]
    return str(found[0]["id"])


def reads(store: Database) -> dict[str, int]:
    assert store.replica is not None
    return dict(store.replica.reads)


def catch_up(primary: str, replica: postgres.Replica) -> None:
    """Wait until everything is replayed that was written, also by transactions that came to nothing."""
    store = Database(primary, replica.url)
    replica.tell("SELECT pg_wal_replay_resume()")
    until = time.monotonic() + 60
    while not reads(store)["replica"] and time.monotonic() < until:
        with store.for_call(store.view, from_replica=True).read():
            pass
    assert reads(store)["replica"]
    store.close()


@given(st.data())
def test_what_is_missing_is_seen_to_be_missing(data: st.DataObject) -> None:
    """Against sets of transactions: of twelve some have ended, and of these some were replayed."""
    ended = data.draw(st.sets(st.integers(1, 12)))
    replayed = data.draw(st.sets(st.integers(1, 12)))
    end, seen = max(ended, default=0) + 1, max(replayed, default=0) + 1
    going = [number for number in range(1, end) if number not in ended]
    said = f"{min(going, default=end)}:{end}:{','.join(map(str, going))}"
    first = min((number for number in range(1, seen) if number not in replayed), default=seen)
    is_in = Snapshot.of(said).is_in(Snapshot.of(f"{first}:{seen}:"))
    if is_in:
        assert ended <= replayed
    elif ended <= replayed:
        # It says nothing of the order in which those ended that are not the first.
        assert first < end


@pytest.mark.slow
def test_own_writes_are_seen_whoever_is_asked(
    clients: list[TestClient], stores: list[Database], primary: str, replica: postgres.Replica
) -> None:
    """Random writes and reads through two servers, while the replica stands still and goes on by turns."""
    rng = random.Random(5)
    uuid = uuid_of(clients[0], {"a.bvh": bvh(3)})
    name, labels, projects = "a", 0, {"lab"}
    for step in range(60):
        if step % 12 == 0:
            replica.tell(f"SELECT pg_wal_replay_{'pause' if step % 24 == 0 else 'resume'}()")
        writer, reader = rng.choice(clients), rng.choice(clients)
        path = f"/api/v1/documents/{uuid}"
        match rng.randrange(5):
            case 0:
                name = f"clip {step}"
                assert writer.patch(path, json={"name": name}, headers={"if-match": "*"}).status_code == 200
            case 1:
                labels += 1
                body = {"name": f"walk{step}", "first": 1, "last": 2}
                answer = writer.post(f"{path}/labels", json=[body], headers={"if-match": "*"})
                assert answer.status_code < 300, answer.text
            case 2:
                projects.add(f"lab {step}")
                upload(writer, {f"{step}.bvh": bvh(3, seed=step)}, project=f"lab {step}")
        assert reader.get(path).json()["name"] == name
        assert len(reader.get(f"{path}/labels").json()["items"]) == labels
        assert set(reader.get("/api/v1/projects").json()["items"]) == projects
        asked = {"q": "count(//motion_name)", "document": uuid}
        assert reader.get("/api/v1/xpath", params=asked).json()["value"] == 2 * labels
    catch_up(primary, replica)
    before = reads(stores[0])
    assert clients[0].get(f"/api/v1/documents/{uuid}").json()["name"] == name
    assert reads(stores[0])["replica"] > before["replica"]
    assert reads(stores[0])["primary"] == before["primary"]


def test_one_that_stands_still_is_passed_over(
    clients: list[TestClient], stores: list[Database], primary: str, replica: postgres.Replica
) -> None:
    uuid = uuid_of(clients[0], {"b.bvh": bvh(3)})
    catch_up(primary, replica)
    replica.tell("SELECT pg_wal_replay_pause()")
    try:
        metrics = clients[1].get("/metrics").text
        assert "mcml_replica_up 1\n" in metrics
        clients[0].patch(f"/api/v1/documents/{uuid}", json={"name": "other"}, headers={"if-match": "*"})
        before = reads(stores[1])
        assert clients[1].get(f"/api/v1/documents/{uuid}").json()["name"] == "other"
        assert reads(stores[1])["primary"] > before["primary"]
        assert reads(stores[1])["replica"] == before["replica"]
        assert stores[1].replica is not None
        assert (stores[1].replica.behind() or 0) > 0
    finally:
        replica.tell("SELECT pg_wal_replay_resume()")


def killing(replica: postgres.Replica, answer: Callable[..., Any]) -> Callable[..., Any]:
    """The same function; before the first time, the replica dies."""
    left = [replica]

    def after(*words: Any, **named: Any) -> Any:
        if left:
            left.pop().kill()
        return answer(*words, **named)

    return after


@pytest.mark.usefixtures("read_again")
def test_one_that_dies_while_it_is_read_is_noticed_by_the_log_alone(
    clients: list[TestClient],
    stores: list[Database],
    primary: str,
    replica: postgres.Replica,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    uuid = uuid_of(clients[0], {"c.bvh": bvh(3)})
    catch_up(primary, replica)
    monkeypatch.setattr(Documents, "get", killing(replica, Documents.get))
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert clients[0].get(f"/api/v1/documents/{uuid}").json()["name"] == "c"
    assert [record.levelname for record in caplog.records if record.name == "mcml.replica"] == ["WARNING"]
    assert reads(stores[0])["replica"] >= 1
    assert "mcml_replica_up 0\n" in clients[0].get("/metrics").text
    replica.start()
    catch_up(primary, replica)
    before = reads(stores[0])["replica"]
    assert clients[0].get(f"/api/v1/documents/{uuid}").status_code == 200
    assert reads(stores[0])["replica"] > before
    # Who stops it again finds it running.
    replica.kill()


@pytest.mark.usefixtures("read_again")
@pytest.mark.parametrize("headers", [{}, {"range": "bytes=100-470000"}], ids=["whole", "range"])
def test_an_answer_goes_on_where_the_replica_dies_while_it_is_sent(
    clients: list[TestClient],
    stores: list[Database],
    primary: str,
    replica: postgres.Replica,
    monkeypatch: pytest.MonkeyPatch,
    headers: dict[str, str],
) -> None:
    uuid = uuid_of(clients[0], {"d.bvh": bvh(FRAMES)})
    path = f"/api/v1/documents/{uuid}/frames?format=npy"
    monkeypatch.setattr(streaming, "PIECE", 1 << 12)
    whole = clients[1].get(path, headers=headers).content
    catch_up(primary, replica)
    sent = []

    def pieces(content: Iterator[bytes]) -> Iterator[bytes]:
        for piece in streaming_pieces(content):
            yield piece
            if not sent:
                replica.kill()
            sent.append(piece)

    streaming_pieces = streaming.pieces
    monkeypatch.setattr(streaming, "pieces", pieces)
    assert clients[0].get(path, headers=headers).content == whole
    assert len(sent[0]) < len(whole)
    assert reads(stores[0])["replica"] == 1


@pytest.mark.usefixtures("read_again")
def test_a_transaction_on_one_that_dies_says_so(
    stores: list[Database], primary: str, replica: postgres.Replica
) -> None:
    with stores[0].write() as tx:
        written = tx.commit
    catch_up(primary, replica)
    store = stores[0].for_call(stores[0].view, from_replica=True)

    def newest(tx: Transaction) -> int:
        if tx.connection.exec_driver_sql("SELECT pg_is_in_recovery()").scalar_one():
            replica.kill()
        return tx.newest_commit()

    with pytest.raises(ReplicaError), store.read() as tx:
        newest(tx)
    replica.start()
    catch_up(primary, replica)
    assert store.ask(newest) == written


def test_one_that_became_a_server_of_its_own_is_none(primary: str) -> None:
    """What is written there by mistake is never read."""
    store = Database(primary, primary)
    with store.for_call(store.view, from_replica=True).read():
        pass
    assert reads(store) == {"replica": 0, "primary": 1}
    store.close()


def test_a_file_has_none(tmp_path: Any) -> None:
    with pytest.raises(StoreError, match="PostgreSQL"):
        Database(f"sqlite:///{tmp_path / 'store.db'}", "postgresql+psycopg://nobody@127.0.0.1/none")
    assert Settings().database_read_url is None
