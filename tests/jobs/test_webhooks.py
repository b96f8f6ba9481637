"""Webhooks: what a receiver gets, checked by another implementation of Standard Webhooks, and what is never sent."""

from __future__ import annotations

import json
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select, update
from standardwebhooks import Webhook

from mcml_service.actions.keeping.keep_room import forget_activity
from mcml_service.app import create_app
from mcml_service.jobs import webhooks
from mcml_service.jobs.webhooks import Sender, is_public
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.team.tables import delivery
from mcml_service.storage.team.webhooks import RETRY_SECONDS
from tests.builders import SECRET, bvh, one_kind, store
from tests.jobs.conftest import Receiver

API = "/api/v1"
KEEPER = {"authorization": f"Bearer {SECRET}"}


def hook(database: Database, url: str, project: str | None = None, kinds: tuple[str, ...] = ()) -> tuple[int, str]:
    """(number, secret)"""
    with database.write("kim") as tx:
        key = None if project is None else tx.projects.get_or_add(project)
        secret, made = tx.webhooks.add(url, kinds, key)
    return made.number, secret


def logged(database: Database, number: int) -> list[Any]:
    with database.read() as tx:
        return tx.webhooks.deliveries(number, None, 100)


def hurry(database: Database) -> None:
    """Let all that waits be due now."""
    with database.write() as tx:
        tx.connection.execute(update(delivery).values(due=0.0))


def test_messages_are_signed_and_sent_once(database: Database, receiver: Receiver) -> None:
    store(database, {"old.bvh": bvh(3, seed=9)}, project="gait")
    _, every = hook(database, receiver.url)
    _, some = hook(database, receiver.url, "gait", ("document", "comment"))
    uuid = store(database, {"a.bvh": bvh(3)}, project="gait")[0]
    store(database, {"b.bvh": bvh(3, seed=1)}, project="dance")
    with database.write("sam") as tx:
        tx.comments.add(tx.documents.get(uuid), 1, "quokka", None, None, None)
    sender = Sender(database, private=True)
    for _ in range(3):
        sender.send_due()
    by_secret: dict[str, list[Any]] = {every: [], some: []}
    for headers, body in receiver.came:
        # A message verifies with one secret alone.
        (secret,) = [one for one in by_secret if _verifies(one, headers, body)]
        by_secret[secret].append(json.loads(body))
        assert b"quokka" not in body, "texts are asked for, not sent"
    assert sorted(one["type"] for one in by_secret[some]) == ["comment.add", "document.import"]
    kinds = [one["type"] for one in sorted(by_secret[every], key=lambda one: one["data"]["id"])]
    assert kinds == ["webhook.add", "webhook.add", "document.import", "document.import", "comment.add"]
    said = next(one for one in by_secret[some] if one["type"] == "comment.add")["data"]
    assert (said["document"], said["author"], said["project"]) == (uuid, "sam", "gait")
    assert len({headers["webhook-id"] for headers, _ in receiver.came}) == len(receiver.came) == 7


def _verifies(secret: str, headers: dict[str, str], body: bytes) -> bool:
    try:
        return bool(Webhook(secret).verify(body, headers))
    except Exception:
        return False


def test_what_fails_is_sent_again_later_and_not_for_ever(database: Database, receiver: Receiver) -> None:
    number, secret = hook(database, receiver.url)
    receiver.answer = lambda _: (500, {})
    sender = Sender(database, private=True)
    for attempt in range(1, len(RETRY_SECONDS) + 2):
        sender.send_due()
        sender.send_due()
        assert len(receiver.came) == attempt, "not before it is due"
        (message,) = logged(database, number)
        assert (message.attempts, message.status, message.problem) == (attempt, 500, "answered 500")
        hurry(database)
    assert message.state == "failed"
    sender.send_due()
    assert len(receiver.came) == len(RETRY_SECONDS) + 1
    receiver.answer = lambda _: (200, {})
    with database.write() as tx:
        tx.webhooks.send_again(number, message.number)
    sender.send_due()
    (message,) = logged(database, number)
    assert (message.state, message.status, message.problem) == ("sent", 200, None)
    assert {headers["webhook-id"] for headers, _ in receiver.came} == {message.message}
    assert set(receiver.types(secret)) == {"webhook.add"}


def test_who_answers_says_when_and_whether(database: Database, receiver: Receiver) -> None:
    number, _ = hook(database, receiver.url)
    sender = Sender(database, private=True)
    receiver.answer = lambda _: (503, {"retry-after": "4000"})
    sender.send_due()
    with database.read() as tx:
        (due,) = tx.connection.execute(select(delivery.c.due)).scalars()
        assert due > time.time() + 3000
    receiver.answer = lambda _: (302, {"location": receiver.url})
    hurry(database)
    sender.send_due()
    assert len(receiver.came) == 2, "redirects are not followed"
    receiver.answer = lambda _: (410, {})
    hurry(database)
    sender.send_due()
    store(database, {"a.bvh": bvh(3)})
    sender.send_due()
    assert len(receiver.came) == 3
    with database.read() as tx:
        assert tx.webhooks.get(number).ended is not None
        assert not tx.webhooks.any_due()


def test_several_servers_send_each_message_once(database: Database, receiver: Receiver) -> None:
    number, secret = hook(database, receiver.url, kinds=("document",))
    store(database, {f"{one}.bvh": bvh(3, seed=one) for one in range(20)})
    senders = [Sender(database, private=True) for _ in range(4)]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda sender: sender.send_due(), senders))
    senders[0].send_due()
    assert receiver.types(secret) == ["document.import"] * 20
    assert len({json.loads(body)["data"]["document"] for _, body in receiver.came}) == 20
    assert {(one.state, one.attempts) for one in logged(database, number)} == {("sent", 1)}


def test_a_message_of_a_server_that_was_killed_is_sent_by_another(database: Database, receiver: Receiver) -> None:
    number, _ = hook(database, receiver.url)
    with database.write() as tx:
        tx.webhooks.queue()
        (killed,) = tx.webhooks.claim(9)
        assert tx.webhooks.claim(9) == []
    sender = Sender(database, private=True)
    sender.send_due()
    assert receiver.came == []
    hurry(database)
    sender.send_due()
    assert len(receiver.came) == 1
    with database.write() as tx:
        tx.webhooks.note_outcome(killed, None, "what comes late counts no more")
    assert [(one.state, one.problem) for one in logged(database, number)] == [("sent", None)]


@pytest.mark.parametrize(
    "address",
    [
        *("127.0.0.1", "10.1.2.3", "172.16.0.1", "192.168.1.1", "169.254.169.254", "0.0.0.0", "100.64.0.1"),
        *("224.0.0.1", "255.255.255.255", "::1", "::", "fe80::1%eth0", "fd00::1", "ff02::1"),
        *("::ffff:127.0.0.1", "::ffff:10.0.0.1"),
        *("64:ff9b::7f00:1", "64:ff9b::a9fe:a9fe", "2002:7f00:1::", "2001:0:a9fe::1", "192.0.2.1", "2001:db8::1"),
    ],
)  # fmt: skip
def test_private_addresses_are_none_of_the_internet(address: str) -> None:
    assert not is_public(address)


@pytest.mark.parametrize("address", ["93.184.215.14", "2606:4700::1111", "::ffff:8.8.8.8", "64:ff9b::808:808"])
def test_others_are(address: str) -> None:
    assert is_public(address)


@one_kind
def test_nothing_is_sent_to_private_networks(database: Database, receiver: Receiver) -> None:
    """Whatever the name meant when the webhook was added."""
    number, _ = hook(database, receiver.url)
    Sender(database, private=False).send_due()
    assert "private network" in logged(database, number)[0].problem
    assert receiver.came == []


@one_kind
def test_a_name_that_means_another_host_a_moment_later_leads_nowhere(
    database: Database, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    hook(database, receiver.url)
    looks: list[str] = []

    def rebinding(host: str, port: int, *_: Any, **__: Any) -> Any:
        looks.append(host)
        # Nobody listens on the first one, which stands for a public address here.
        address = "127.0.0.2" if len(looks) == 1 else "127.0.0.1"
        return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (address, port))]

    def public(address: str) -> bool:
        return address == "127.0.0.2"

    monkeypatch.setattr(socket, "getaddrinfo", rebinding)
    monkeypatch.setattr(webhooks, "is_public", public)

    def connected(address: tuple[str, int], *more: Any, **asked: Any) -> socket.socket:
        assert address[0] == "127.0.0.2"
        raise ConnectionRefusedError

    monkeypatch.setattr(socket, "create_connection", connected)
    Sender(database, private=False).send_due()
    assert looks == ["localhost"]
    assert receiver.came == []


@one_kind
def test_who_shows_no_certificate_of_the_name_gets_nothing(
    database: Database, receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SSL_CERT_FILE")
    unknown, _ = hook(database, receiver.url)
    monkeypatch.setattr(webhooks, "SEND_SECONDS", 5.0)
    Sender(database, private=True).send_due()
    assert "certificate" in logged(database, unknown)[0].problem.lower()
    assert receiver.came == []


@one_kind
def test_an_answer_that_drips_is_given_up(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webhooks, "SEND_SECONDS", 2.0)
    stop = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.settimeout(30)

        def drip() -> None:
            connection, _ = listening.accept()
            with connection:
                connection.sendall(b"HTTP/1.1 200 OK\r\nx-slow: ")
                while not stop.wait(0.02):
                    try:
                        connection.sendall(b"x")
                    except OSError:
                        return

        thread = threading.Thread(target=drip, daemon=True)
        thread.start()
        number, _ = hook(database, f"http://127.0.0.1:{listening.getsockname()[1]}/")
        Sender(database, private=True).send_due()
        stop.set()
        thread.join()
    assert "ReadTimeout" in logged(database, number)[0].problem


@pytest.mark.parametrize(
    "url",
    [
        *("http://example.com/", "ftp://example.com/", "https://user:word@example.com/", "https://example.com/#part"),
        *("https://127.0.0.1/", "https://localhost:8000/", "https://[::1]/", "https://0x7f000001/", "https://10.0.0.1/"),
        *("https:///nowhere", "https://name.invalid/", "https://example.com:99999/", "https://exämple.com/"),
    ],
)  # fmt: skip
@one_kind
def test_addresses_that_are_refused(client: TestClient, url: str) -> None:
    answer = client.post(f"{API}/webhooks", json={"url": url})
    assert answer.status_code in (400, 422), answer.text
    assert client.get(f"{API}/webhooks").json()["items"] == []


@one_kind
def test_owners_keep_the_webhooks_of_their_projects(database: Database, receiver: Receiver) -> None:
    app = create_app(Settings(import_processes=1, webhook_private=True), database, lambda: SECRET)
    store(database, {"a.bvh": bvh(3)}, project="mine")
    with database.write() as tx:
        tx.accounts.add("boss", "owner", "x")
        for name, role in (("ed", "editor"), ("own", "owner"), ("far", "owner")):
            tx.accounts.add(name, "member", "x")
            tx.members.put(tx.projects.get_or_add("far away" if name == "far" else "mine"), name, role)
        secrets = {name: tx.tokens.add(f"of {name}", owner=tx.accounts.get(name)) for name in ("ed", "own", "far")}
    keeper = TestClient(app, client=("127.0.0.1", 1), headers=KEEPER)
    ed, own, far = (
        TestClient(app, client=("10.0.0.7", 1), headers={"authorization": f"Bearer {secrets[name]}"})
        for name in ("ed", "own", "far")
    )
    with keeper:
        asked = {"url": receiver.url, "project": "mine", "kinds": ["document"]}
        made = own.post(f"{API}/webhooks", json=asked)
        assert made.status_code == 201, made.text
        mine, secret = made.json()["number"], made.json()["secret"]
        assert secret not in own.get(f"{API}/webhooks").text
        assert ed.post(f"{API}/webhooks", json=asked).status_code == 403
        assert far.post(f"{API}/webhooks", json=asked).status_code == 404
        assert own.post(f"{API}/webhooks", json={"url": receiver.url}).status_code == 403
        everything = keeper.post(f"{API}/webhooks", json={"url": receiver.url, "kinds": ["token"]}).json()["number"]
        assert [one["number"] for one in own.get(f"{API}/webhooks").json()["items"]] == [mine]
        assert far.get(f"{API}/webhooks").json()["items"] == []
        assert {one["number"] for one in keeper.get(f"{API}/webhooks").json()["items"]} == {mine, everything}
        # The server sends by itself.
        store(database, {"b.bvh": bvh(3, seed=2)}, project="mine")
        assert receiver.heard.wait(20)
        assert receiver.types(secret) == ["document.import"]
        log = f"{API}/webhooks/{mine}/messages"
        (message,) = own.get(log).json()["items"]
        for client, status in ((ed, 403), (far, 404), (own, 202)):
            assert client.post(f"{log}/{message['number']}").status_code == status
            assert client.get(log).status_code == (200 if client is own else status)
        assert own.get(f"{API}/webhooks/{everything}/messages").status_code == 404
        assert far.delete(f"{API}/webhooks/{mine}").status_code == 404
        assert own.delete(f"{API}/webhooks/{mine}").status_code == 204
        assert own.get(log).status_code == 404
        seen = {
            (one["what"], one["subject"])
            for one in own.get(f"{API}/activity", params={"kind": "webhook"}).json()["items"]
        }
        assert seen == {("add", str(mine)), ("remove", str(mine))}
        assert ed.get(f"{API}/activity", params={"kind": "webhook"}).json()["items"] == []


@one_kind
def test_old_messages_are_forgotten(database: Database, receiver: Receiver) -> None:
    number, _ = hook(database, receiver.url)
    Sender(database, private=True).send_due()
    store(database, {"a.bvh": bvh(3)})
    with database.write() as tx:
        tx.webhooks.queue()
        tx.connection.execute(update(delivery).values(created="2020-01-31T10:00:00.000Z"))
    forget_activity(database, 30)
    assert [one.state for one in logged(database, number)] == ["waiting"]
