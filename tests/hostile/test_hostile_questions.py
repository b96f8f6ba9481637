"""Questions made to take all memory, all time, or every place: each is answered or refused within its limits, seen from
outside of the process, and others are answered meanwhile."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random

import httpx
import psutil
import pytest
from hypothesis import settings

from mcml_service.storage.database import Database
from tests import fuzz
from tests.api.test_admission import until
from tests.builders import bvh, one_kind, store
from tests.hostile.hostile_expressions import hostile_expression


def grown(first: str, by: str, times: int, end: str) -> str:
    """An expression whose value grows with each of its variables."""
    return f"let $a:={first} return " + f"let $a:={by} return " * times + end


DOUBLED = grown("//frame", "($a,$a)", 40, "count($a)")
BOMBS = {
    "pattern": "matches('aaa', 'a{2147483647}')",
    "nested pattern": "matches('aaa', '((a{900}){900}){900}')",
    "replace": "replace('aaa', 'a{2147483647}', 'b')",
    "tokenize": "tokenize('aaa', '(a{1,2000000000}){5}')",
    "wide classes": "matches('aaa', '" + r"(\p{L}|\p{N}){1,999}" * 40 + "')",
    "doubled nodes": DOUBLED,
    "doubled values": grown("1", "($a,$a)", 40, "count($a)"),
    "doubled text": grown("'abcdefghij'", "concat($a,$a)", 30, "string-length($a)"),
    "joined text": grown("'abcdefghij'", "string-join(($a,$a,$a))", 25, "string-length($a)"),
    "grown text": grown("'aaaaaaaaaa'", "replace($a,'a','aaaa')", 20, "string-length($a)"),
    "range": "sum(1 to 2000000000)",
    "range of ranges": "count(for $i in 1 to 20000 return for $j in 1 to 20000 return $i * $j)",
    "reversed range": "reverse(1 to 900000000)[1]",
    "sorted range": "sort(for $i in 1 to 60000000 return ($i * 7919) mod 104729)[1]",
    "texts of a range": "string-length(string-join(for $i in 1 to 90000000 return concat('abcdefgh', $i), ' '))",
    "frames by frames": "count(for $a in //frame return for $b in //frame return for $c in //frame return 1)",
    "values of all": "distinct-values(for $a in //frame return for $b in //frame return concat($a/@id, $b/@id))",
    "deep predicates": "count(//*[count(//*[count(//*[count(//*) > 1]) > 1]) > 1])",
    "many steps": "count(" + "//*" * 200 + ")",
    "parentheses": "(" * 4000 + "1" + ")" * 4000,
    "many unions": "|".join(["//frame"] * 1000),
    "long name": "//" + "x" * 9_000,
}
ORDINARY = "count(for $frame in //frame return $frame)"
"""A harmless question that needs a place for heavy ones."""
SECONDS = 1
MEMORY_MIB = 384
MOST_RESIDENT = 1536 << 20
OK = (200, 422)


def environment(url: str, folder: Path) -> dict[str, str]:
    own = {"MCML_DATABASE": url, "MCML_QUERY_SECONDS": str(SECONDS), "MCML_QUERY_MEMORY_MIB": str(MEMORY_MIB)}
    return {**os.environ, **own, "XDG_DATA_HOME": str(folder), "MCML_DERIVE": "no"}


class Resident(threading.Thread):
    """Looks at the resident size of a process and of all that it started, and keeps the largest."""

    def __init__(self, pid: int) -> None:
        super().__init__(daemon=True)
        self.most = 0
        self._seen = psutil.Process(pid)
        self._ended = threading.Event()

    def run(self) -> None:
        while not self._ended.wait(0.02):
            total = 0
            with suppress(psutil.NoSuchProcess):
                for one in [self._seen, *self._seen.children(recursive=True)]:
                    with suppress(psutil.NoSuchProcess):
                        total += one.memory_info().rss
            self.most = max(self.most, total)

    def __enter__(self) -> Resident:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self.join()


@contextmanager
def served(url: str, folder: Path) -> Iterator[tuple[httpx.Client, Resident]]:
    """A server of its own, and what it takes."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "mcml_service.cli", "serve", "--port", str(port)]
    with (folder / "said.txt").open("wb") as said:
        server = subprocess.Popen(command, env=environment(url, folder), stdout=said, stderr=said, process_group=0)
    try:
        with (
            httpx.Client(base_url=f"http://127.0.0.1:{port}/api/v1", timeout=120) as client,
            Resident(server.pid) as resident,
        ):
            until(lambda: _answers(client))
            yield client, resident
    finally:
        server.terminate()
        server.wait(30)


def _answers(client: httpx.Client) -> bool:
    with suppress(httpx.TransportError):
        return client.get("/documents").status_code == 200
    return False


@pytest.mark.slow
@one_kind
def test_no_question_stops_the_server(database_url: str, database: Database, tmp_path: Path) -> None:
    store(database, {f"{name}.bvh": bvh(200) for name in "abc"})
    with served(database_url, tmp_path) as (client, resident):
        with ThreadPoolExecutor(4) as pool:
            asked = {name: pool.submit(client.post, "/xpath", json={"q": text}) for name, text in BOMBS.items()}
            answers = {name: future.result() for name, future in asked.items()}
        assert {
            name: answer.status_code for name, answer in answers.items() if answer.status_code not in (200, 422)
        } == {}
        # Every place came back.
        assert client.get("/xpath", params={"q": ORDINARY}).json()["value"] == 600
        assert client.get("/running-queries").json() == {"items": []}
        assert resident.most < MOST_RESIDENT


@pytest.mark.slow
@one_kind
def test_quick_questions_are_answered_beside_hostile_ones(
    database_url: str, database: Database, tmp_path: Path
) -> None:
    """The quick ones are of the same client, which has one place for heavy questions."""
    store(database, {"a.bvh": bvh(200)})
    with served(database_url, tmp_path) as (client, resident), ThreadPoolExecutor(8) as pool:
        asked = [pool.submit(client.post, "/xpath", json={"q": BOMBS["range of ranges"]}) for _ in range(8)]
        until(lambda: client.get("/running-queries").json()["items"])
        for _ in range(20):
            assert client.get("/xpath", params={"q": "count(//frame)"}).json()["value"] == 200
        assert client.get("/documents", params={"xpath": "//frame[@id = 7]"}).json()["total"] == 1
        assert not all(one.done() for one in asked)
        assert {one.result().status_code for one in asked} == {422}
        assert resident.most < MOST_RESIDENT


@pytest.mark.slow
@one_kind
def test_who_leaves_or_is_ended_gives_the_place_back(database_url: str, database: Database, tmp_path: Path) -> None:
    """Also who has it taken by the owner, who sees what runs."""
    store(database, {"a.bvh": bvh(200)})
    with served(database_url, tmp_path) as (client, _), ThreadPoolExecutor(1) as pool:
        for _ in range(6):
            with suppress(httpx.TimeoutException):
                client.post("/xpath", json={"q": DOUBLED}, timeout=0.3)
        assert client.get("/xpath", params={"q": ORDINARY}).json()["value"] == 200
        until(lambda: client.get("/running-queries").json() == {"items": []})
        asked = pool.submit(client.post, "/xpath", json={"q": DOUBLED})
        until(lambda: client.get("/running-queries").json()["items"])
        (running,) = client.get("/running-queries").json()["items"]
        assert running["q"] == DOUBLED
        assert client.delete(f"/running-queries/{running['id']}").status_code == 204
        assert asked.result().json()["code"] == "query-cancelled"
        assert client.delete(f"/running-queries/{running['id']}").status_code == 404


@pytest.mark.slow
@one_kind
@pytest.mark.parametrize(
    "name", fuzz.share(["doubled nodes", "pattern", "doubled text", "range of ranges", "deep predicates"], 5)
)
def test_no_question_takes_all_of_a_command(name: str, database_url: str, database: Database, tmp_path: Path) -> None:
    store(database, {"a.bvh": bvh(200)})
    command = [sys.executable, "-m", "mcml_service.cli", "xpath", BOMBS[name]]
    with (
        subprocess.Popen(
            command, env=environment(database_url, tmp_path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        ) as asking,
        Resident(asking.pid) as resident,
    ):
        said, _ = asking.communicate(timeout=60)
    assert asking.returncode in (0, 1), said.decode()
    assert b"Traceback" not in said
    assert resident.most < MOST_RESIDENT


@one_kind
@pytest.mark.fuzz(seeds=20)
def test_expressions_that_chance_makes_to_hurt(
    database_url: str, database: Database, tmp_path: Path, seed: int
) -> None:
    """Each is answered or refused, the server stays within its memory, and others are answered."""
    store(database, {f"{name}.bvh": bvh(100) for name in "abc"})
    chance = Random(seed)
    count = 250 if settings.get_current_profile_name() == "fuzz" else 40
    expressions = [hostile_expression(chance) for _ in range(count)]
    with served(database_url, tmp_path) as (client, resident):
        with ThreadPoolExecutor(4) as pool:
            asked = [pool.submit(client.post, "/xpath", json={"q": text, "limit": 10}) for text in expressions]
            answers = [future.result() for future in asked]
        odd = [(text, one.text) for text, one in zip(expressions, answers, strict=True) if one.status_code not in OK]
        assert odd == []
        assert client.get("/xpath", params={"q": ORDINARY}).json()["value"] == 300
        assert resident.most < MOST_RESIDENT


@pytest.mark.slow
@one_kind
def test_what_evaluates_ends_with_a_server_that_is_killed(
    database_url: str, database: Database, tmp_path: Path
) -> None:
    store(database, {"a.bvh": bvh(200)})
    with served(database_url, tmp_path) as (client, _), ThreadPoolExecutor(1) as pool:
        asked = pool.submit(client.post, "/xpath", json={"q": BOMBS["frames by frames"]})
        until(lambda: client.get("/running-queries").json()["items"])
        server = psutil.Process(asked_by(client))
        started = server.children(recursive=True)
        assert started
        server.kill()
        until(lambda: not any(one.is_running() and one.status() != psutil.STATUS_ZOMBIE for one in started))
        with suppress(httpx.TransportError):
            asked.result()


def asked_by(client: httpx.Client) -> int:
    """The process that listens where a client asks."""
    port = client.base_url.port
    return next(one.pid for one in psutil.net_connections("tcp") if one.laddr.port == port and one.status == "LISTEN")
