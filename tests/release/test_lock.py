"""What is locked: all that pyproject.toml asks for, by sums, from nowhere in particular; and its audit."""

from __future__ import annotations

import json
import re
import threading
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.release.audit import LOCK, audit

ROOT = Path(__file__).resolve().parents[2]
SERVER = ROOT / "requirements.lock"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]


def locked(lock: Path) -> dict[str, list[str]]:
    """The versions of each package: more than one where versions of Python need others."""
    found: dict[str, list[str]] = {}
    for name, version in re.findall(r"^(\S+)==(\S+)", lock.read_text(encoding="utf-8"), re.MULTILINE):
        found.setdefault(canonicalize_name(name), []).append(version)
    return found


@pytest.mark.parametrize(
    ("lock", "wanted"),
    [
        (SERVER, [*PROJECT["project"]["dependencies"], *EXTRAS["server"], *EXTRAS["plots"]]),
        (
            LOCK,
            [
                *PROJECT["project"]["dependencies"],
                *(item for extra in EXTRAS.values() for item in extra),
                *PROJECT["dependency-groups"]["dev"],
                *PROJECT["build-system"]["requires"],
            ],
        ),
    ],
    ids=["server", "dev"],
)
def test_all_that_is_asked_for_is_locked(lock: Path, wanted: list[str]) -> None:
    versions = locked(lock)
    for requirement in map(Requirement, wanted):
        if requirement.name == PROJECT["project"]["name"]:
            continue  # One extra has all of another.
        held = versions.get(canonicalize_name(requirement.name))
        assert held, f"{requirement} is not in {lock.name}: run `make lock`"
        assert all(version in requirement.specifier for version in held), f"{requirement}: run `make lock`"


def test_a_server_has_what_was_tested() -> None:
    tested = locked(LOCK)
    assert {name: tested.get(name) for name in locked(SERVER)} == locked(SERVER)


@pytest.mark.parametrize("lock", [SERVER, LOCK], ids=lambda path: path.name)
def test_sums_are_locked_and_no_place(lock: Path) -> None:
    text = re.sub(r"^ *#.*\n", "", lock.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert re.search(r"://|@|--index|--find-links", text) is None
    packages = re.split(r"\n(?=\S)", text.strip())
    assert len(packages) > 50
    assert all(re.search(r"--hash=sha256:[0-9a-f]{64}\b", package) for package in packages)


@contextmanager
def faults_of(known: dict[str, list[dict[str, Any]]]) -> Iterator[str]:
    """The address of a database of faults, by names of packages."""

    class Database(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            asked = json.loads(self.rfile.read(int(self.headers["content-length"])))
            content = json.dumps({"vulns": known.get(asked["package"]["name"], [])}).encode()
            self.send_response(200)
            self.send_header("content-type", "application/json")
            self.send_header("content-length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: object) -> None:
            """Nobody reads it."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Database)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/v1/query"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


FAULT = {
    "id": "TEST-1",
    "modified": "2026-01-01T00:00:00Z",
    "affected": [{
        "package": {"ecosystem": "PyPI", "name": "lxml"},
        "versions": ["6.1.0"],
        "ranges": [{"type": "ECOSYSTEM", "events": [{"introduced": "0"}, {"fixed": "6.1.1"}]}],
    }],
}  # fmt: skip


@pytest.fixture
def lock(tmp_path: Path) -> Path:
    path = tmp_path / "some.lock"
    path.write_text("".join(f"{name}==6.1.0 --hash=sha256:{'0' * 64}\n" for name in ("lxml", "numpy")))
    return path


@pytest.mark.slow
def test_a_known_fault_is_named(lock: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with faults_of({"lxml": [FAULT]}) as address:
        assert audit(lock, more=("--osv-url", address)) == 1
    assert capsys.readouterr().out.splitlines() == [
        "lxml 6.1.0: TEST-1, mended in 6.1.1",
        "audit of packages: 2 asked, 1 known faults",
    ]
    with faults_of({}) as address:
        assert audit(lock, more=("--osv-url", address), required=True) == 0


def test_without_a_network_it_is_skipped_in_one_line(lock: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = ("--osv-url", "http://127.0.0.1:9/v1/query")
    assert audit(lock, more=nowhere) == 0
    assert capsys.readouterr().out == "audit of packages skipped: no network\n"
    assert audit(lock, more=nowhere, required=True) == 1
    assert capsys.readouterr().out.startswith("audit of packages failed: ")


def test_a_lock_that_cannot_be_read_is_no_lack_of_network(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.lock"
    broken.write_text("lxml>=6\n")
    assert audit(broken) == 1
    assert capsys.readouterr().out.startswith("audit of packages failed: ")
