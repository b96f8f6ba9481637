"""A real server and a real browser. Chromium is Debian's; where it is missing, these tests are skipped; in CI they
fail."""

from __future__ import annotations

import asyncio
import os
import random
import shutil
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn

from mcml_service.api.studio import STATIC
from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import bvh

FLAGS = ["--gaia-url=http://127.0.0.1:9", "--component-updater=url-source=http://127.0.0.1:9/"]
"""Nothing leaves: Chromium's own questions to its maker."""
PATIENCE = 15_000  # ms
WATCH = """window.violations = [];
addEventListener("securitypolicyviolation", event => {
  violations.push(event.violatedDirective + " " + event.blockedURI);
});"""
LAG = float(os.environ.get("MCML_TEST_LAG", "0"))
"""Seconds that an answer may be late, drawn for each: what a page does that does not wait shows then (CONTRIBUTING)."""
NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot")


def chromium() -> str:
    """The browser, best without what only windows need: a third less work. Skips, or fails in CI."""
    for name in ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"):
        found = shutil.which(name)
        if found:
            return found
    why = "no Chromium on this machine: apt-get install chromium-headless-shell"
    if os.environ.get("CI"):
        pytest.fail(why)
    pytest.skip(why)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    # Of the module: sync Playwright keeps an event loop running, which every later asyncio.run() would trip over.
    api = pytest.importorskip("playwright.sync_api")
    path = chromium()
    api.expect.set_options(timeout=PATIENCE)
    with api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield launched
        launched.close()


@dataclass
class Served:
    """A server on a port of its own."""

    url: str
    database: Database
    token: str | None = None

    def client(self) -> httpx.Client:
        headers = {"authorization": f"Bearer {self.token}"} if self.token else {}
        return httpx.Client(base_url=f"{self.url}/api/v1", headers=headers, timeout=30)

    def upload(self, name: str, content: bytes, **form: Any) -> str:
        with self.client() as client:
            answer = client.post("/documents", files={"file": (name, content)}, data=form)
            answer.raise_for_status()
            return str(answer.json()["documents"][0]["id"])

    def get(self, path: str, **params: Any) -> Any:
        with self.client() as client:
            answer = client.get(path, params=params)
            answer.raise_for_status()
            return answer.json()


def late(app: Any) -> Any:
    """The application behind a slow and uneven line: requests reach it late, and not in the order of asking."""
    drawn = random.Random()

    async def answering(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http" and scope["path"].startswith("/api/"):
            await asyncio.sleep(drawn.random() * LAG)
        await app(scope, receive, send)

    return answering


def serve(store: Path, folder: Path, *, closed: bool) -> Iterator[Served]:
    """A server on a copy of an SQLite store in a folder. closed: it asks everybody for a token."""
    assert (STATIC / "index.html").is_file(), "the studio is not built: make web"
    settings = Settings(database=f"sqlite:///{folder}/store.db", host="127.0.0.1", login="always" if closed else "auto")
    shutil.copy(store, folder / "store.db")
    database = Database(settings.database_url)
    token = None
    if closed:
        with database.write("test") as tx:
            token = tx.tokens.add("tester")
    # Named as TCP, or asyncio lets each answer wait 40 ms for an acknowledgement.
    listener = socket.socket(proto=socket.IPPROTO_TCP)
    listener.bind(("127.0.0.1", 0))
    app = late(create_app(settings, database)) if LAG else create_app(settings, database)
    server = uvicorn.Server(uvicorn.Config(app, log_level="error", timeout_graceful_shutdown=1))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    served = Served(f"http://127.0.0.1:{listener.getsockname()[1]}", database, token)
    while not server.started:
        assert thread.is_alive(), "the server ended"
        threading.Event().wait(0.01)
    yield served
    server.should_exit = True
    thread.join(20)
    database.close()


@pytest.fixture(params=["open", "session"])
def studio(request: pytest.FixtureRequest, sqlite_template: Path, tmp_path: Path) -> Iterator[Served]:
    """A server with an empty store: open as a personal one, or asking for a session."""
    yield from serve(sqlite_template, tmp_path, closed=request.param == "session")


one_door = pytest.mark.parametrize("studio", [pytest.param("open", marks=pytest.mark.fuzz), "session"], indirect=True)
"""Of tests whose pages ask nothing of who is let in that the journeys do not ask of both doors; in `make fuzz` both."""
open_door = pytest.mark.parametrize("studio", ["open", pytest.param("session", marks=pytest.mark.fuzz)], indirect=True)
"""The same at the other door: of the journeys `make test` takes half by one, half by the other."""


@pytest.fixture
def open_studio(sqlite_template: Path, tmp_path: Path) -> Iterator[Served]:
    yield from serve(sqlite_template, tmp_path, closed=False)


@dataclass
class Visit:
    """A page, and what went wrong in it that no test wanted."""

    page: Any
    url: str
    wanted: set[int] = field(default_factory=set)
    """Statuses of refusals that the test provokes."""
    said: list[str] = field(default_factory=list)

    def open(self, path: str) -> Any:
        self.page.goto(self.url + path)
        return self.page


@pytest.fixture
def visit_of(browser: Any) -> Iterator[Any]:
    """visit_of(served, **context): a new visitor, let in where a session is needed. At the end nothing may have gone
    wrong: no error in the console, no breach of the policy, no request to elsewhere."""
    visits: list[tuple[Any, Visit]] = []

    def made(served: Served, **more: Any) -> Visit:
        context = browser.new_context(
            **{"viewport": {"width": 1280, "height": 800}, "locale": "en", "accept_downloads": True, **more}
        )
        context.set_default_timeout(PATIENCE)
        context.add_init_script(WATCH)
        if served.token:
            context.request.post(f"{served.url}/api/v1/session", data={"token": served.token})
        page = context.new_page()
        visit = Visit(page, served.url)
        page.on("pageerror", lambda error: visit.said.append(f"error: {error}"))
        page.on("console", lambda message: _console(visit, message))
        page.on("response", lambda answer: _answer(visit, answer))
        page.on("request", lambda asked: _request(visit, asked))
        visits.append((context, visit))
        return visit

    yield made
    for context, visit in visits:
        if not visit.page.is_closed():
            visit.said += visit.page.evaluate("window.violations ?? []")
        context.close()
        assert visit.said == []


def _console(visit: Visit, message: Any) -> None:
    # What the graphics driver says of being slow, and refusals, which are looked at as answers.
    if message.type == "error" and "GPU stall" not in message.text and "Failed to load resource" not in message.text:
        visit.said.append(f"console: {message.text}")


def _answer(visit: Visit, answer: Any) -> None:
    if answer.status >= 400 and answer.status not in visit.wanted:
        visit.said.append(f"{answer.status} {answer.url}")


def _request(visit: Visit, asked: Any) -> None:
    if not asked.url.startswith((visit.url, "data:", "blob:")):
        visit.said.append(f"outside: {asked.url}")


@pytest.fixture
def visit(studio: Served, visit_of: Any) -> Visit:
    found: Visit = visit_of(studio)
    return found


def walk(frames: int = 60, **more: Any) -> bytes:
    """A leg that moves."""
    return bvh(frames, names=NAMES, **more)
