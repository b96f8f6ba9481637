"""What a server's log says, and the ids by which requests are found in it."""

from __future__ import annotations

import io
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.api.logs import Faults, JsonLine, Line
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.xpath.query_pool import PooledQueries as Queries
from tests.builders import SECRET, one_kind

API = "/api/v1"
OWNER = {"authorization": f"Bearer {SECRET}"}


@contextmanager
def log(level: int = logging.WARNING, again: float = 60.0, lines: logging.Formatter | None = None) -> Iterator[Any]:
    """A log, and what it has so far."""
    stream = io.StringIO()
    handler = Faults(stream, again)
    handler.setFormatter(lines or JsonLine())
    # A scheduler that another test left in this process tells of itself when the machine is slow.
    handler.addFilter(lambda record: not record.name.startswith("distributed"))
    root, ours = logging.getLogger(), logging.getLogger("mcml")
    before = ours.level
    root.addHandler(handler)
    ours.setLevel(level)
    try:
        yield lambda: stream.getvalue().splitlines()
    finally:
        handler.close()
        root.removeHandler(handler)
        ours.setLevel(before)


def fail(number: int) -> None:
    if number < 0:
        raise ValueError(number)
    raise OSError(24, f"Too many open files, for the {number}th time")


def tell(number: int) -> None:
    try:
        fail(number)
    except (OSError, ValueError) as error:
        logging.getLogger("asyncio").error(f"out of resource {number}", exc_info=error)  # as asyncio does


def test_a_fault_is_told_once_and_counted() -> None:
    with log() as told:
        for number in range(3_000):
            tell(number)
        tell(-1)
        assert [json.loads(line)["message"] for line in told()] == ["out of resource 0", "out of resource -1"]
        assert "Too many open files" in json.loads(told()[0])["traceback"]
    last = json.loads(told()[-1])
    assert (last["message"], last["repeated"], len(told())) == ("out of resource 0", 2_999, 3)
    with log(again=0) as told:
        tell(1)
        tell(2)
        assert len(told()) == 2


def test_faults_that_all_differ_are_not_remembered_for_ever() -> None:
    with log() as told:
        for number in range(2_000):
            logging.getLogger("mcml.x").warning(f"fault {number}")  # so each is another
        assert len(told()) == 2_000
        (handler,) = (one for one in logging.getLogger().handlers if isinstance(one, Faults))
        assert len(handler._seen) <= 500


def test_lines_as_text() -> None:
    with log(lines=Line()) as told:
        logging.getLogger("mcml.x").warning("%s is %s", "disk", "full")
        logging.getLogger("mcml.x").error("GET %s", "/a\n2026 error mcml.x -: forged\x1b[31m\u2028!")
        assert told()[0].endswith("warning mcml.x -: disk is full")
        assert told()[1].endswith(r"error mcml.x -: GET /a\n2026 error mcml.x -: forged\x1b[31m\u2028!")
        assert len(told()) == 2


def test_a_fault_writes_no_lines_of_its_own() -> None:
    with log(lines=Line()) as told:
        try:
            raise ValueError("bad name\n2026-01-01T00:00:00.000+00:00 error mcml.x -: forged\r\x1b[31m")
        except ValueError as error:
            logging.getLogger("mcml.x").error("failed", exc_info=error)
        head, *rest = told()
        assert head.endswith("error mcml.x -: failed")
        assert rest
        assert all(line.startswith("    ") for line in rest)
        assert not set("\r\x1b") & set("".join(rest))


def test_lines_as_json_hold_any_text() -> None:
    record = logging.makeLogRecord({"msg": "no file %s", "args": (b"a\xff\n.bvh".decode("utf-8", "surrogateescape"),)})
    line = JsonLine().format(record)
    assert line.isascii()
    assert "\n" not in line
    assert json.loads(line)["message"] == "no file a\udcff\n.bvh"


@one_kind
def test_a_request_is_found_by_its_id(database: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("a fault of ours")

    monkeypatch.setattr(Queries, "answer", fail)
    app = create_app(Settings(), database, lambda: SECRET)
    where: dict[str, Any] = {"base_url": "http://127.0.0.1:8000", "client": ("127.0.0.1", 1), "headers": OWNER}
    with log(logging.INFO) as told, TestClient(app, raise_server_exceptions=False, **where) as client:
        mine = client.get(f"{API}/documents/none", headers={"x-request-id": "lab-7"})
        assert mine.headers["x-request-id"] == mine.json()["request"] == "lab-7"
        for bad in ("a b", "x" * 65, "{}", "a;b"):
            other = client.get(f"{API}/documents", headers={"x-request-id": bad}).headers["x-request-id"]
            assert len(other) == 16
        failed = client.get(f"{API}/xpath", params={"q": "//bone"})
        name = failed.headers["x-request-id"]
        assert (failed.status_code, failed.json()["request"]) == (500, name)
        assert name in failed.json()["detail"]
        assert 'method="GET",status="500"' in client.get("/metrics").text
    lines = [json.loads(line) for line in told()]
    (fault,) = [line for line in lines if line["level"] == "error"]
    assert (fault["request"], "a fault of ours" in fault["traceback"]) == (name, True)
    by_id = {line["request"]: line for line in lines if line["source"] == "mcml.requests"}
    assert by_id["lab-7"]["status"] == 404
    assert by_id["lab-7"]["path"] == f"{API}/documents/none"
    assert by_id["lab-7"]["method"] == "GET"
    assert by_id[name]["status"] == 500


def test_what_was_told_is_not_told_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """uvicorn logs an error that left the application, which is in the log by then."""
    # A server of another test may have given it a log of its own.
    monkeypatch.setattr(logging.getLogger("uvicorn"), "propagate", True)
    error = RuntimeError("once")
    with log() as told:
        logging.getLogger("mcml.api").error("failed", exc_info=error)
        logging.getLogger("uvicorn.error").error("Exception in ASGI application\n", exc_info=error)
        logging.getLogger("uvicorn.error").error("Exception in ASGI application\n", exc_info=RuntimeError("other"))
        assert [json.loads(line)["source"] for line in told()] == ["mcml.api", "uvicorn.error"]
