"""SIGKILL a server and the commands beside it at random moments, while others import, edit, delete, purge, back up and
start jobs: what was acknowledged is there, what was not is whole or absent, and the store is sound."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import httpx
import pytest

from mcml_service.storage.database import Database
from mcml_service.storage.work.jobs import ENDED
from tests.api.test_admission import until
from tests.builders import bvh, store
from tests.motion.bodies.made import person

GONE = (httpx.TransportError, OSError)
"""What clients meet when a server dies."""


@dataclass
class Told:
    """What the server acknowledged, and what it was asked."""

    imported: dict[str, bytes] = field(default_factory=dict)
    asked: dict[str, bytes] = field(default_factory=dict)
    revisions: dict[str, int] = field(default_factory=dict)
    deleted: set[str] = field(default_factory=set)
    jobs: set[str] = field(default_factory=set)
    lock: threading.Lock = field(default_factory=threading.Lock)


@dataclass
class Scene:
    url: str
    folder: Path
    token: str
    base: list[str]
    told: Told = field(default_factory=Told)
    commands: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def run(self, *command: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, "MCML_DATABASE": self.url, "MCML_IMPORT_PROCESSES": "1", "MCML_JOB_WORKERS": "1"}
        environment["XDG_DATA_HOME"] = str(self.folder)
        said = (self.folder / "said.txt").open("ab")
        started = subprocess.Popen(
            [sys.executable, "-m", "mcml_service.cli", *command],
            env=environment,
            stdout=said,
            stderr=said,
            process_group=0,
        )
        self.commands.append(started)
        return started

    @contextmanager
    def served(self) -> Iterator[httpx.Client]:
        """A server that is killed at the end, with what it started."""
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.run("serve", "--port", str(port))
        headers = {"authorization": f"Bearer {self.token}"}
        with httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", headers=headers, timeout=60) as client:
            until(lambda: answers(client))
            try:
                yield client
            finally:
                self.kill()

    def kill(self) -> None:
        for command in self.commands:
            with suppress(ProcessLookupError):
                os.killpg(command.pid, signal.SIGKILL)
            command.wait()
        self.commands.clear()


def answers(client: httpx.Client) -> bool:
    with suppress(httpx.TransportError):
        return client.get("/projects").status_code == 200
    return False


def imports(client: httpx.Client, scene: Scene, random: Random, number: int) -> None:
    name, content = f"new {number}", bvh(random.choice([3, 40, 900]), seed=number)
    scene.told.asked[name] = content
    answer = client.post("/documents", files={"file": (f"{name}.bvh", content)})
    if answer.status_code == 201:
        scene.told.imported[answer.json()["documents"][0]["id"]] = content


def edits(client: httpx.Client, scene: Scene, random: Random, number: int) -> None:
    uuid = random.choice(scene.base)
    edit = random.choice([{"do": "reverse", "first": 1, "last": 9}, {"do": "insert", "at": 1, "frames": 2}])
    answer = client.post(f"/documents/{uuid}/frames", json={"edits": [edit]}, headers={"if-match": "*"})
    if answer.status_code == 200:
        revision = answer.json()["revision"]
        with scene.told.lock:
            scene.told.revisions[uuid] = max(revision, scene.told.revisions.get(uuid, 0))


def deletes(client: httpx.Client, scene: Scene, random: Random, number: int) -> None:
    """A document that was imported; and sometimes it is purged by a command."""
    known = [uuid for uuid in list(scene.told.imported) if uuid not in scene.told.deleted]
    if len(known) < 4:
        time.sleep(0.02)
        return
    uuid = random.choice(known)
    # From now on it may be gone.
    content = scene.told.imported.pop(uuid)
    answer = client.delete(f"/documents/{uuid}", headers={"if-match": "*"})
    if answer.status_code == 204:
        scene.told.deleted.add(uuid)
        if random.random() < 0.1:
            scene.run("purge", uuid, "--yes")
    else:
        scene.told.imported[uuid] = content


def analyses(client: httpx.Client, scene: Scene, random: Random, number: int) -> None:
    """One, beside a backup by a command."""
    answer = client.post("/analyses/beats", json={"inputs": {"documents": [random.choice(scene.base)]}})
    if answer.status_code == 202:
        scene.told.jobs.add(answer.json()["id"])
    scene.run("db", "backup", str(scene.folder / f"{number}.backup"))
    time.sleep(2)


def load(client: httpx.Client, scene: Scene, seed: int, seconds: float) -> None:
    """Everybody works for a while; then the server and all commands are killed in the middle of it."""
    stop = threading.Event()
    number = iter(range(seed * 100_000, seed * 100_000 + 100_000))

    def work(kind: Any, own: int) -> None:
        random = Random(own)
        while not stop.is_set():
            with suppress(*GONE):
                kind(client, scene, random, next(number))

    kinds = (imports, imports, edits, deletes, analyses)
    threads = [threading.Thread(target=work, args=(kind, seed * 10 + at)) for at, kind in enumerate(kinds)]
    for thread in threads:
        thread.start()
    until(lambda: len(scene.told.imported) > 0 and len(scene.told.revisions) > 0 and len(scene.told.jobs) > 0)
    time.sleep(seconds)
    stop.set()
    scene.kill()
    for thread in threads:
        thread.join()
    scene.kill()


def require_sound(client: httpx.Client, scene: Scene) -> None:
    """What a server that was started again tells."""
    told = scene.told
    listed = {item["id"]: item["name"] for item in client.get("/documents?limit=1000").json()["items"]}
    for uuid, content in told.imported.items():
        assert uuid in listed, "an acknowledged import is there"
        assert client.get(f"/documents/{uuid}/export?format=bvh").content == content
    for uuid, name in listed.items():
        if name in told.asked:
            assert client.get(f"/documents/{uuid}/export?format=bvh").content == told.asked[name], "whole or absent"
    for uuid, revision in told.revisions.items():
        assert client.get(f"/documents/{uuid}").json()["revision"] >= revision
    assert not told.deleted & set(listed)
    for job in told.jobs:
        until(lambda job=job: client.get(f"/jobs/{job}").json()["state"] in ENDED)  # type: ignore[misc]
        assert client.get(f"/jobs/{job}").json()["state"] == "done"
    database = Database(scene.url)
    assert database.check(past=True) == []
    database.close()
    for backup in scene.folder.glob("*.backup"):
        copy = Database(f"sqlite:///{backup}")
        assert copy.check() == [], "a backup is whole or absent"
        copy.close()
        backup.unlink()


def campaign(database: Database, url: str, folder: Path, seed: int, kills: int) -> Told:
    files = {f"base {number}.bvh": person(number, 60) for number in range(3)}
    base = store(database, files)
    with database.write() as tx:
        token = tx.tokens.add("load")
    scene, random = Scene(url, folder, token, base), Random(seed)
    for number in range(kills):
        with scene.served() as client:
            if number:
                require_sound(client, scene)
            load(client, scene, seed * 1000 + number, random.uniform(0.3, 1.6))
    with scene.served() as client:
        require_sound(client, scene)
    return scene.told


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "kills"), [("sqlite", 1)], indirect=["kind"])
def test_killed_under_load(database: Database, database_url: str, tmp_path: Path, kills: int) -> None:
    told = campaign(database, database_url, tmp_path, 1, kills)
    assert told.asked
    assert told.imported
    assert told.revisions
    assert told.jobs


@pytest.mark.fuzz(seeds=20)
def test_killed_many_times(database: Database, database_url: str, tmp_path: Path, seed: int) -> None:
    campaign(database, database_url, tmp_path, seed, 10)
