"""Who may come in: what settings, store and origin of a request decide, and what it cannot make us believe."""

from __future__ import annotations

import http.client
import os
import re
import shutil
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn
from fastapi.testclient import TestClient
from starlette.datastructures import Headers

from mcml_service.api.authentication import FORWARDING
from mcml_service.api.forwarded import as_the_client_sent_it
from mcml_service.app import create_app
from mcml_service.local_secret import NAME, keep_secret, read_secret
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import fuzz
from tests.builders import SECRET, bvh

DOCUMENTS = "/api/v1/documents"
LOOPBACK = Settings(host="127.0.0.1")
OWNER = {"authorization": f"Bearer {SECRET}"}


@pytest.fixture
def fresh(sqlite_template: Path, tmp_path: Path) -> Iterator[Database]:
    """One person's new store."""
    shutil.copy(sqlite_template, tmp_path / "store.db")
    store = Database(f"sqlite:///{tmp_path / 'store.db'}")
    yield store
    store.close()


def ask(database: Database, settings: Settings = LOOPBACK, peer: str = "127.0.0.1", **headers: str) -> int:
    """The status that a request without a token gets, or with what headers say."""
    app = create_app(settings, database, lambda: SECRET)
    with TestClient(app, base_url="http://127.0.0.1:8000", client=(peer, 50_000)) as client:
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        return client.get(DOCUMENTS, headers=named).status_code


@contextmanager
def listening(app: Any) -> Iterator[int]:
    """The port at which an application is served."""
    listener = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(uvicorn.Config(app, log_level="error", proxy_headers=False))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
    thread.start()
    try:
        yield listener.getsockname()[1]
    finally:
        server.should_exit = True
        thread.join()
        listener.close()


@contextmanager
def bare_proxy(port: int) -> Iterator[int]:
    """What nginx's bare `proxy_pass http://127.0.0.1:PORT` does: a Host of its own, no word of the client."""

    class Passed(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            headers = {
                name: value for name, value in self.headers.items() if name.lower() not in ("host", "connection")
            }
            upstream = http.client.HTTPConnection("127.0.0.1", port)
            upstream.request("GET", self.path, headers={**headers, "Host": f"127.0.0.1:{port}", "Connection": "close"})
            answer = upstream.getresponse()
            content = answer.read()
            self.send_response(answer.status)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)
            upstream.close()

        def log_message(self, *_: object) -> None:
            """Nobody reads it."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Passed)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield server.server_port
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@contextmanager
def nginx(port: int, folder: Path) -> Iterator[int]:
    """The same by nginx itself."""
    program = shutil.which("nginx") or "/usr/sbin/nginx"
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        own = probe.getsockname()[1]
    paths = " ".join(
        f"{name}_temp_path {folder / name};" for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    (folder / "nginx.conf").write_text(
        f"daemon off; master_process off; pid {folder / 'pid'}; error_log {folder / 'errors'};\n"
        f"events {{}}\nhttp {{ access_log off; {paths}\n"
        f"server {{ listen 127.0.0.1:{own}; location / {{ proxy_pass http://127.0.0.1:{port}; }} }} }}\n"
    )
    process = subprocess.Popen([program, "-c", folder / "nginx.conf", "-p", folder, "-e", folder / "errors"])
    try:
        _until_answers(own, process)
        yield own
    finally:
        process.terminate()
        process.wait(30)


def _until_answers(port: int, process: subprocess.Popen[Any]) -> None:
    while process.poll() is None:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return
        except OSError:
            # Without a rest this would take a processor from the program that it waits for.
            time.sleep(0.02)
    raise AssertionError(f"ended with {process.returncode}")


def has_nginx() -> bool:
    return shutil.which("nginx") is not None or Path("/usr/sbin/nginx").exists()


def through_a_proxy(secret: str | None, proxy: int) -> None:
    """Nobody comes in without a token, whatever name is asked for."""
    with httpx.Client(base_url=f"http://127.0.0.1:{proxy}") as client:
        for host in (f"127.0.0.1:{proxy}", "localhost", "mocap.example"):
            assert client.get(DOCUMENTS, headers={"host": host}).status_code == 401, host
        assert client.get(DOCUMENTS, headers={"authorization": "Bearer mcml_local_guess"}).status_code == 401
        if secret is not None:
            assert client.get(DOCUMENTS, headers={"authorization": f"Bearer {secret}"}).status_code == 200


def test_a_store_with_a_token_is_closed_behind_a_bare_proxy(database: Database) -> None:
    with database.write() as tx:
        secret = tx.tokens.add("kim")
    app = create_app(LOOPBACK, database, lambda: SECRET)
    with listening(app) as port, bare_proxy(port) as proxy:
        through_a_proxy(secret, proxy)


@pytest.mark.skipif(not has_nginx(), reason="nginx is not installed")
def test_a_store_with_a_token_is_closed_behind_nginx(fresh: Database, tmp_path: Path) -> None:
    with fresh.write() as tx:
        secret = tx.tokens.add("kim")
    with listening(create_app(LOOPBACK, fresh)) as port, nginx(port, tmp_path) as proxy:
        through_a_proxy(secret, proxy)


def test_a_store_of_several_people_is_closed_without_any_token(database: Database, kind: str) -> None:
    """PostgreSQL is; a fresh file is open, where the service knows that it listens on this machine alone."""
    assert ask(database) == (200 if kind == "sqlite" else 401)
    assert ask(database, authorization=f"Bearer {SECRET}") == 200
    with listening(create_app(LOOPBACK, database)) as port, bare_proxy(port) as proxy:
        if kind == "postgresql":
            through_a_proxy(None, proxy)


def test_the_first_token_closes_the_store(fresh: Database) -> None:
    app = create_app(LOOPBACK, fresh, lambda: SECRET)
    with TestClient(app, base_url="http://127.0.0.1:8000", client=("127.0.0.1", 50_000)) as client:
        made = client.post(DOCUMENTS, files=[("file", ("a.bvh", bvh(2)))]).json()["documents"][0]["id"]
        with fresh.write() as tx:
            secret = tx.tokens.add("kim")
            old = tx.tokens.add("old", expires="2001-01-01T00:00:00.000Z")
        refused = client.get(DOCUMENTS)
        assert refused.status_code == 401
        assert refused.headers["www-authenticate"] == "Bearer"
        assert "mcml token add" in refused.json()["remedy"]
        for wrong in ("mcml_nope", "mcml_local_nope", "mcml_local_ä", old, ""):
            bearer = {"authorization": f"Bearer {wrong}".encode()}
            assert client.get(DOCUMENTS, headers=bearer).status_code == 401, wrong
        for right, author in ((secret, "kim"), (SECRET, "local")):
            headers = {"authorization": f"bearer {right}"}
            client.patch(f"{DOCUMENTS}/{made}", json={"name": author}, headers={**headers, "if-match": "*"})
            history = client.get(f"{DOCUMENTS}/{made}/revisions", headers=headers).json()
            assert author in (history["items"][0]["author"], history["items"][-1]["author"])
        assert client.get("/healthz").status_code == client.get("/readyz").status_code == 200
        with fresh.write() as tx:
            tx.tokens.remove("kim")
        assert client.get(DOCUMENTS).status_code == 401, "an expired token closes too"
    with fresh.read() as tx:
        assert secret not in str(tx.connection.exec_driver_sql("SELECT * FROM token").all())


@pytest.mark.parametrize(
    ("settings", "status"),
    [
        (Settings(host="127.0.0.1"), 200),
        (Settings(host="localhost"), 200),
        (Settings(host="127.0.0.1", login="always"), 401),
        (Settings(host="0.0.0.0"), 401),
        (Settings(host="192.168.1.2"), 401),
        (Settings(), 401),
    ],
    ids=lambda value: str(getattr(value, "host", value)),
)
def test_settings_close_a_fresh_store(fresh: Database, settings: Settings, status: int) -> None:
    assert ask(fresh, settings) == status
    assert ask(fresh, settings, authorization=f"Bearer {SECRET}") == 200


@pytest.mark.parametrize("name", [*sorted(FORWARDING), "x-forwarded-for", "x-forwarded-host", "x-forwarded-anything"])
def test_what_was_passed_on_needs_a_token(fresh: Database, name: str) -> None:
    for settings in (LOOPBACK, Settings(host="127.0.0.1", trusted_proxies="127.0.0.1")):
        assert ask(fresh, settings, **{name: "127.0.0.1"}) == 401
        assert ask(fresh, settings, **{name: "127.0.0.1"}, **OWNER) == 401, "the secret is for this machine"


def test_other_machines_need_a_token(fresh: Database) -> None:
    assert ask(fresh, peer="192.168.1.7") == 401
    assert ask(fresh, peer="192.168.1.7", **OWNER) == 401
    assert ask(fresh, peer="::1") == 200
    with fresh.write() as tx:
        secret = tx.tokens.add("kim")
    assert ask(fresh, peer="192.168.1.7", authorization=f"Bearer {secret}") == 200


def test_an_open_store_answers_only_to_names_of_this_machine(fresh: Database) -> None:
    for host in ("localhost:8000", "[::1]:8000", "127.0.0.2"):
        assert ask(fresh, host=host) == 200, host
    for host in ("rebinding.example", "127.0.0.1.evil.example", "[::1", ""):
        assert ask(fresh, host=host) == 403, host


def test_a_trusted_proxy_says_who_asks_and_as_whom() -> None:
    def seen(peer: str, trusted: str, **headers: str) -> tuple[str, str, str | None]:
        sent = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
        scope = {"client": (peer, 1), "scheme": "http", "headers": [(b"host", b"127.0.0.1:8000"), *sent]}
        found = as_the_client_sent_it(scope, Settings(trusted_proxies=trusted).proxies)
        return found["client"][0], found["scheme"], Headers(scope=found).get("host")

    forwarded = {
        "x_forwarded_for": "6.6.6.6, 198.51.100.7, 10.0.0.9",
        "x_forwarded_proto": "https",
        "x_forwarded_host": "evil.example, mocap.example",
    }
    plain = ("127.0.0.1", "http", "127.0.0.1:8000")
    assert seen("127.0.0.1", "", **forwarded) == plain
    assert seen("127.0.0.1", "10.0.0.0/8", **forwarded) == plain
    assert seen("127.0.0.1", "127.0.0.1", **forwarded) == ("10.0.0.9", "https", "mocap.example")
    assert seen("127.0.0.1", "127.0.0.1, 10.0.0.0/8", **forwarded) == ("198.51.100.7", "https", "mocap.example")
    assert seen("127.0.0.1", "0.0.0.0/0", x_forwarded_proto="gopher") == plain
    assert seen("fd00::1", "fd00::/8", x_forwarded_for="2001:db8::5")[0] == "2001:db8::5"


def test_pages_of_the_proxys_own_name_may_write(fresh: Database) -> None:
    with fresh.write() as tx:
        secret = tx.tokens.add("kim")
    headers = {
        "authorization": f"Bearer {secret}",
        "origin": "https://mocap.example",
        "x-forwarded-host": "mocap.example",
        "x-forwarded-for": "198.51.100.7",
    }
    for trusted, status in (("", 403), ("127.0.0.1", 201)):
        app = create_app(Settings(host="127.0.0.1", trusted_proxies=trusted), fresh)
        with TestClient(app, base_url="http://127.0.0.1:8000", client=("127.0.0.1", 50_000)) as client:
            files = [("file", ("a.bvh", bvh(2)))]
            assert client.post(DOCUMENTS, files=files, headers=headers).status_code == status


def test_the_secret_is_a_file_that_only_its_owner_reads(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    assert read_secret(folder) is None
    made = keep_secret(folder)
    assert made is not None
    assert stat.S_IMODE((folder / NAME).stat().st_mode) == 0o600
    assert read_secret(folder) == keep_secret(folder) == made
    (folder / NAME).chmod(0o640)
    assert read_secret(folder) is None
    other = keep_secret(folder)
    assert other not in (None, made)
    assert stat.S_IMODE((folder / NAME).stat().st_mode) == 0o600
    (folder / NAME).write_bytes(b"\xff\xfe")
    assert read_secret(folder) is None
    assert [path.name for path in folder.iterdir()] == [NAME]
    (tmp_path / "file").touch()
    assert keep_secret(tmp_path / "file") is None


@pytest.fixture
def run(tmp_path: Path, sqlite_template: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts `python -m …` with a home of its own and no settings; ends what it started."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
    environment |= {"XDG_DATA_HOME": str(tmp_path), "PYTHONPATH": os.getcwd(), "PYTHONUNBUFFERED": "1"}
    (tmp_path / "mcml").mkdir()
    shutil.copy(sqlite_template, tmp_path / "mcml" / "mcml.db")
    started: list[subprocess.Popen[str]] = []

    def start(*words: str, **more: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", *words]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        started.append(subprocess.Popen(command, env=environment | more, **pipes))
        return started[-1]

    yield start
    for process in started:
        process.terminate()
        process.communicate(timeout=30)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.slow
def test_a_server_that_was_not_told_where_it_listens_is_closed(run: Any, tmp_path: Path) -> None:
    port = free_port()
    words = ("uvicorn", "--factory", "mcml_service.app:app_from_environment", "--host", "0.0.0.0", "--port", str(port))
    _until_answers(port, run(*words))
    address = f"http://127.0.0.1:{port}{DOCUMENTS}"
    refused = httpx.get(address)
    assert refused.status_code == 401
    assert "MCML_HOST" in refused.json()["detail"]
    secret = read_secret(tmp_path / "mcml")
    assert httpx.get(address, headers={"authorization": f"Bearer {secret}"}).status_code == 200


@pytest.mark.slow
@pytest.mark.parametrize("is_thorough", [False, pytest.param(True, marks=pytest.mark.fuzz)])
def test_commands_of_this_machine_go_on_behind_the_first_token(run: Any, is_thorough: bool) -> None:
    """Some on the store, some on its server; in `make fuzz` each on both."""
    port = free_port()
    server = run("mcml_service.cli", "serve", "--port", str(port))
    assert "MCML Repository on" in server.stdout.readline()
    assert "until the first account or token is made" in server.stdout.readline()
    _until_answers(port, server)
    address = f"http://127.0.0.1:{port}"
    assert httpx.get(address + DOCUMENTS).status_code == 200
    assert run("mcml_service.cli", "token", "add", "kim").wait(60) == 0
    assert httpx.get(address + DOCUMENTS).status_code == 401
    on_the_server = ("--server", address)
    for where in ((), on_the_server) if is_thorough else ((),):
        listed = run("mcml_service.cli", "ls", "--json", *where)
        assert '"total": 0' in listed.communicate(timeout=60)[0], where
        assert listed.returncode == 0
    for where in ((), on_the_server) if is_thorough else (on_the_server,):
        # A command that works through the API itself.
        assert run("mcml_service.cli", "jobs", "list", *where).wait(60) == 0, where
    assert run("mcml_service.cli", "ls", "--server", address, MCML_TOKEN="mcml_wrong").wait(60) == 1


@pytest.mark.slow
@pytest.mark.parametrize("how", fuzz.share([{"MCML_LOGIN": "always"}, {"MCML_HOST": "0.0.0.0"}], 2))
def test_a_closed_server_says_so_and_how_its_first_account_is_made(run: Any, how: dict[str, str]) -> None:
    port = free_port()
    server = run("mcml_service.cli", "serve", "--port", str(port), **how)
    server.stdout.readline()
    assert server.stdout.readline() == "Closed: requests need an account or a token.\n"
    told, code = "", None
    while code is None:
        # As wide as the terminal is, the link goes on in another line.
        told += server.stdout.readline().strip()
        code = re.search(r"/login\?link=([\w-]{43})", told)
    assert re.search("first ?account", told)
    _until_answers(port, server)
    asked = {"link": code[1], "name": "kim", "password": "four words in a row"}
    with httpx.Client(base_url=f"http://127.0.0.1:{port}") as client:
        assert client.post("/api/v1/session", json=asked).status_code == 201
        assert client.get("/api/v1/account").json()["role"] == "owner"


@pytest.mark.parametrize(
    ("name", "value"), [("MCML_TRUSTED_PROXIES", "nginx"), pytest.param("MCML_LOGIN", "never", marks=pytest.mark.fuzz)]
)
def test_settings_that_make_no_sense_are_named(run: Any, name: str, value: str) -> None:
    command = run("mcml_service.cli", "ls", **{name: value})
    errors = command.communicate(timeout=60)[1]
    assert command.returncode == 1
    assert errors.startswith(f"mcml: {name}: ")
