"""The studio's files as the server gives them, and what they are made of."""

from __future__ import annotations

import gzip
import json
import re
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from mcml.formats import WRITERS
from mcml_service.api.studio import PAGES, STATIC, page_addresses
from service.web.build import WEB, fingerprint, is_current
from tests.builders import one_kind
from tests.web.types import TYPES, types

START_UP = 250_000
"""Bytes of script, compressed, before what is loaded later."""


@pytest.mark.slow
def test_the_types_are_those_of_the_api() -> None:
    assert TYPES.read_text(encoding="utf-8") == types(), "run `make docs`"


def test_what_is_built_is_built_of_these_sources() -> None:
    assert is_current(), "run `make web`"
    before = fingerprint()
    probe = WEB / "src/probe.css"
    probe.write_text("a {}")
    try:
        assert fingerprint() != before
    finally:
        probe.unlink()
    assert fingerprint() == before


def test_a_row_of_pages_is_an_address(tmp_path: Path) -> None:
    """A page is added by a row and its component: a unit test of the studio holds the rows against words and files."""
    rows = json.loads((WEB / "pages.json").read_text(encoding="utf-8"))
    assert {"/", "/library", "/clips/{id}", "/settings", "/settings/{id}"} < set(page_addresses(PAGES))
    added = {"name": "floor", "path": "/floor", "about": "any", "title": "floor", "file": "floor/FloorPage"}
    (tmp_path / "pages.json").write_text(json.dumps([*rows, added]))
    before = set(page_addresses(PAGES))
    assert set(page_addresses(tmp_path / "pages.json")) - before == {"/floor", "/floor/{id}"}


@pytest.mark.parametrize("path", [address.replace("{id}", "0") for address in page_addresses(PAGES)])
@one_kind
def test_pages_are_strict_and_asked_for_anew(client: TestClient, path: str) -> None:
    answer = client.get(path)
    assert answer.status_code == 200
    assert "no-cache" in answer.headers["cache-control"].split(", ")
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "http" not in re.sub(r'"/[^"]*"', "", answer.text.replace("http-equiv", "")), (
        "nothing is loaded from elsewhere"
    )


@one_kind
def test_built_files_are_compressed_and_kept(client: TestClient) -> None:
    name = next(file.name for file in (STATIC / "assets").glob("index-*.js"))
    kept = "public, max-age=31536000, immutable"
    sizes = []
    for encoding, ending in (("identity", ""), ("gzip", ".gz"), ("br", ".br")):
        answer = client.get(f"/assets/{name}", headers={"accept-encoding": encoding})
        assert answer.headers["cache-control"] == kept
        assert answer.headers.get("content-encoding", "identity") == encoding
        assert answer.headers["content-type"].startswith("text/javascript")
        assert int(answer.headers["content-length"]) == (STATIC / "assets" / (name + ending)).stat().st_size
        sizes.append(int(answer.headers["content-length"]))
    assert sizes == sorted(sizes, reverse=True)


@one_kind
def test_no_path_leaves_the_folder(client: TestClient) -> None:
    for path in ("/assets/..%2Findex.html", "/assets/%2e%2e", "/assets/.sources", "/assets/nothing.js"):
        assert client.get(path).status_code == 404, path


def test_start_up_is_small() -> None:
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    scripts = re.findall(r'(?:src|href)="(/assets/[^"]+\.js)"', page)
    assert scripts
    total = sum(len(gzip.compress((STATIC / script[1:]).read_bytes(), 9)) for script in scripts)
    assert total <= START_UP


PANEL = 60_000
"""Bytes that opening an analysis may load at once, gzip, with what it shares; three.js and CodeMirror apart."""
ANALYSES = ("Reach", "Dance", "Faces", "Measure", "Analyses", "Result")


def is_scene_or_editor(chunk: str) -> bool:
    text = (STATIC / "assets" / chunk).read_text(encoding="utf-8")
    return "WebGLRenderer" in text or "cm-content" in text


def loaded_with(chunk: str, seen: set[str]) -> set[str]:
    """A chunk and those that it imports at once."""
    if chunk not in seen:
        seen.add(chunk)
        text = (STATIC / "assets" / chunk).read_text(encoding="utf-8")
        for found in re.findall(r'(?:from|import)\s*"\./([^"]+\.js)"', text):
            loaded_with(found, seen)
    return seen


def test_pages_of_analyses_are_small() -> None:
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    start: set[str] = set()
    for script in re.findall(r'(?:src|href)="/assets/([^"]+\.js)"', page):
        loaded_with(script, start)
    panels = [file.name for name in ANALYSES for file in (STATIC / "assets").glob(f"{name}Page-*.js")]
    assert len(panels) == len(ANALYSES)
    for panel in panels:
        chunks = loaded_with(panel, set()) - start
        own = {chunk for chunk in chunks if not is_scene_or_editor(chunk)}
        size = sum(len(gzip.compress((STATIC / "assets" / chunk).read_bytes(), 9)) for chunk in own)
        assert size <= PANEL, f"{panel}: {size:,} bytes, {sorted(own)}"


def test_the_scene_never_fetches() -> None:
    for file in (WEB / "src/scene").rglob("*.ts*"):
        assert "fetch" not in file.read_text(encoding="utf-8").replace("never fetches", ""), file


def test_questions_are_asked_in_dialogs_of_the_studio() -> None:
    asks = re.compile(r"(?<![\w.])(window\.)?(prompt|confirm|alert)\(")
    found = [path.name for path in (WEB / "src").rglob("*.ts*") if asks.search(path.read_text(encoding="utf-8"))]
    assert found == [], "the browser's own boxes stop the page: ui/Dialog.tsx, ui/AskName.tsx"


def test_no_format_is_named() -> None:
    """The studio asks the server for formats: one that is added appears in every menu."""
    named = re.compile(rf"""["'`](?:{"|".join(WRITERS)})["'`]""")
    sources = [path for path in (WEB / "src").rglob("*.ts*") if ".test." not in path.name]
    own = [path for path in sources if path.name != "types.gen.ts" and path.parent.name != "testing"]
    found = [path.name for path in own if named.search(path.read_text(encoding="utf-8"))]
    assert found == [], "state/session/formats.ts knows them"


def test_files_are_short() -> None:
    for file in (WEB / "src").rglob("*.ts*"):
        if file.name != "types.gen.ts":
            assert len(file.read_text(encoding="utf-8").splitlines()) <= 400, file
