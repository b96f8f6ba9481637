"""`mcml sync`: on a server and on a store, watching, stopped and started again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

from mcml.client.sync import looks
from mcml.client.sync.events import Event
from mcml.errors import ConflictError, UnavailableError
from mcml_service.app import create_app
from mcml_service.cli import syncing
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.test_authentication import listening
from tests.builders import bvh
from tests.cli.test_cli import Mcml, environment, mcml  # noqa: F401

SYNC = textwrap.dedent(
    """
    import os, signal, sys
    sys.path[:0] = {paths!r}
    from mcml.client.sync.bindings import Bindings
    from mcml_service.cli import main

    seen = 0
    save = Bindings.save

    def saving(record):
        global seen
        seen += 1
        if seen == {fatal}:
            os.kill(os.getpid(), signal.SIGKILL)
        save(record)

    Bindings.save = saving
    sys.argv = ["mcml", "sync", *{words!r}]
    main()
    """
)


@pytest.fixture(autouse=True)
def _at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(looks, "SETTLE_SECONDS", 0)


@pytest.fixture
def takes(tmp_path: Path) -> Path:
    folder = tmp_path / "takes"
    (folder / "day 1").mkdir(parents=True)
    (folder / "walk.bvh").write_bytes(bvh(3))
    (folder / "day 1" / "걷기.bvh").write_bytes(bvh(4, seed=4))
    return folder


@pytest.fixture
def server(tmp_path: Path, sqlite_template: Path) -> Iterator[str]:
    path = tmp_path / "served.db"
    path.write_bytes(sqlite_template.read_bytes())
    database = Database(f"sqlite:///{path}")
    with listening(create_app(Settings(host="127.0.0.1"), database)) as port:
        yield f"http://127.0.0.1:{port}"
    database.close()


def test_a_folder_on_a_server(mcml: Mcml, takes: Path, server: str) -> None:  # noqa: F811
    words = ("sync", str(takes), "--project", "film", "--server", server)
    code, output, errors = mcml(*words)
    assert (code, errors) == (0, "")
    assert "stored   day 1/걷기.bvh" in output
    assert output.endswith("2 stored, 0 replaced, 0 unchanged\n")
    (takes / "walk.bvh").write_bytes(bvh(5))
    (takes / "bad.bvh").write_bytes(bvh(3)[:-40])
    code, output, _ = mcml(*words, "--json")
    answer = json.loads(output)
    assert (code, answer["counts"]) == (3, {"replaced": 1, "failed": 1, "unchanged": 1})
    [failed] = [row for row in answer["files"] if row["action"] == "failed"]
    assert (failed["path"], bool(failed["detail"]), bool(failed["remedy"])) == ("bad.bvh", True, True)
    assert mcml(*words)[0] == 1
    listed = json.loads(mcml("ls", "--project", "film", "--server", server, "--json")[1])
    assert sorted((item["name"], item["frames"]) for item in listed["items"]) == [("walk", 5), ("걷기", 4)]
    code, _, errors = mcml("sync", str(takes), "--project", "gait", "--server", server)
    assert (code, "synced with the project film" in errors) == (1, True)


def test_a_folder_with_a_store_and_another_folder(mcml: Mcml, takes: Path, tmp_path: Path) -> None:  # noqa: F811
    assert "2 stored" in mcml("sync", str(takes))[1]
    other = tmp_path / "other"
    other.mkdir()
    assert "2 fetched" in mcml("sync", str(other), "--both")[1]
    assert sorted(path.name for path in other.glob("*.bvh")) == ["walk.bvh", "걷기.bvh"]
    assert mcml("sync", str(tmp_path / "nothing"))[0] == 2


def test_watching_goes_on_until_it_is_stopped(
    mcml: Mcml,  # noqa: F811
    takes: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rounds = 0

    def change(seconds: float) -> None:
        nonlocal rounds
        assert seconds == 5
        rounds += 1
        if rounds == 2:
            (takes / "walk.bvh").write_bytes(bvh(6))
        if rounds == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(syncing, "pause", change)
    code, output, _ = mcml("sync", str(takes), "--watch", "--interval", "5")
    assert code == 0
    assert output.count("stored") == 4, "two files, and the summaries of two rounds"
    assert "replaced walk.bvh" in output
    assert len(output.splitlines()) == 5


def test_watching_waits_for_a_repository_that_is_away(
    mcml: Mcml,  # noqa: F811
    takes: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rounds = 0
    run = syncing.FolderSync.run

    def sometimes(self: syncing.FolderSync) -> Iterator[Event]:
        nonlocal rounds
        rounds += 1
        if rounds == 2:
            raise UnavailableError("The server is unreachable.")
        if rounds == 4:
            raise KeyboardInterrupt
        return run(self)

    monkeypatch.setattr(syncing, "pause", lambda seconds: None)
    monkeypatch.setattr(syncing.FolderSync, "run", sometimes)
    code, output, errors = mcml("sync", str(takes), "--watch")
    assert (code, rounds, errors) == (0, 4, "mcml: The server is unreachable. Trying again.\n")
    assert "2 stored" in output


def test_one_sync_at_a_time(mcml: Mcml, takes: Path) -> None:  # noqa: F811
    with syncing.hold(takes):
        code, _, errors = mcml("sync", str(takes))
        assert (code, "Another mcml sync" in errors) == (1, True)
        with pytest.raises(ConflictError), syncing.hold(takes):
            pass
    assert mcml("sync", str(takes))[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize("fatal", [1, 2])
def test_a_killed_sync_continues(mcml: Mcml, takes: Path, tmp_path: Path, server: str, fatal: int) -> None:  # noqa: F811
    assert mcml("sync", str(takes), "--server", server)[0] == 0
    for path in ("walk.bvh", "new.bvh"):
        (takes / path).write_bytes(bvh(9))
        os.utime(takes / path, (1e9, 1e9))
    words = [str(takes), "--server", server]
    program = SYNC.format(paths=[path for path in sys.path if path], fatal=fatal, words=words)
    killed = subprocess.run([sys.executable, "-c", program], env=environment(tmp_path), capture_output=True)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    code, _, errors = mcml("sync", *words)
    assert (code, errors) == (0, "")
    assert mcml("sync", *words)[1].endswith("0 stored, 0 replaced, 3 unchanged\n")
    listed = json.loads(mcml("ls", "--server", server, "--json")[1])
    assert sorted(item["name"] for item in listed["items"]) == ["new", "walk", "걷기"]
    assert all(item["revision"] <= 2 for item in listed["items"])
