"""What people write stays text, wherever it is shown or looked for; and secrets are what they were given as."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from lxml import etree

from mcml_service.app import create_app
from mcml_service.passwords import MOST, hash_password, opens
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import SECRET, bvh, one_kind, upload

API = "/api/v1"
ROOT = Path(__file__).resolve().parents[2]
TRAPS = (
    """"><script>alert(1)</script>""",
    "'; DROP TABLE document; --",
    "' OR '1'='1",
    "]]>&amp;<!-- a -->",
    "a'b\"c\\d`e${f}",
    "; touch /tmp/mcml-was-here",
    "\u202egnp.bvh",
)

BANNED = ("eval", "exec", "compile", "os.system", "os.popen", "hashlib.md5", "hashlib.sha1")


@pytest.mark.parametrize("trap", TRAPS)
def test_names_and_words_are_text(client: TestClient, trap: str) -> None:
    """In JSON, XML, headers, SQL of both databases, and as what is looked for."""
    uuid = upload(client, {"walk.bvh": bvh(2)}, label="hop")["documents"][0]["id"]  # type: ignore[index]
    place = f"{API}/documents/{uuid}"
    changed = client.patch(place, json={"name": trap, "description": trap}, headers={"if-match": "*"})
    assert changed.status_code == 200, changed.text
    found = client.get(place).json()
    assert (found["name"], found["description"]) == (trap, trap)
    assert [one["id"] for one in client.get(f"{API}/documents", params={"name": trap}).json()["items"]] == [uuid]
    assert client.get(f"{API}/documents", params={"motion_name": trap}).json()["total"] == 0
    assert client.get(f"{API}/documents", params={"motion_name": "hop"}).json()["total"] == 1
    exported = client.get(f"{place}/mcml")
    etree.fromstring(exported.content)
    assert b"<script" not in exported.content
    asked = {"q": "//frame[motion_name = $name]", "variables": {"name": trap}}
    assert client.post(f"{API}/xpath", json=asked).json()["items"] == []
    for name, value in client.get(f"{place}/export?format=bvh").headers.items():
        assert value.isascii(), name
        assert not set(value) & set("\r\n\0"), name
    assert client.get(f"{API}/documents").json()["total"] == 1


@one_kind
@pytest.mark.parametrize("trap", TRAPS)
def test_pages_without_a_script_show_text(database: Database, trap: str) -> None:
    app: Any = create_app(Settings(), database, lambda: SECRET)
    visitor = TestClient(app, base_url="http://lab.example", client=("10.0.0.7", 1))
    pages = [
        visitor.get("/login", params={"then": trap}),
        visitor.get("/login", params={"link": trap}),
        visitor.get("/login", params={"invitation": trap}),
        visitor.post("/login", data={"name": trap, "password": trap, "then": trap}),
        visitor.post("/login", data={"invitation": trap, "name": "kim", "password": trap}),
        visitor.get(f"/{trap}", headers={"accept": "text/html"}),
    ]
    for page in pages:
        assert page.headers["content-type"] == "text/html; charset=utf-8"
        assert "<script" not in page.text
        assert "script-src" not in page.headers["content-security-policy"]
        shown = etree.fromstring(page.content, etree.HTMLParser(encoding="utf-8"))
        assert not shown.xpath("//script | //comment() | //@*[starts-with(name(), 'on')]")
        assert not [value for value in shown.xpath("//input/@type") if value not in ("hidden", "password")]
        assert {one.get("type") for one in shown.xpath("//input[@name='password' or @name='token']")} <= {"password"}
        assert not shown.xpath("//input[@name='password'][not(@autocomplete)] | //@onpaste")


def test_the_studio_makes_no_markup_of_text() -> None:
    """Text becomes text nodes and attributes, as Preact and the DOM make them; nothing is run that was put together."""
    raw = re.compile(
        r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|srcdoc|dangerouslySet|new Function|\beval\("
    )
    sources = [path for path in (ROOT / "service/web/src").rglob("*.ts*") if ".test." not in path.name]
    assert len(sources) > 100
    assert [path.name for path in sources if raw.search(path.read_text(encoding="utf-8"))] == []


@pytest.mark.slow
def test_the_service_runs_nothing_that_was_put_together() -> None:
    """No code, no line of a shell, no pickles of others; and no digest that is broken."""
    wrong = []
    for folder in ("service", "schemas", "mcml"):
        for path in (ROOT / folder).rglob("*.py"):
            if "node_modules" in path.parts:
                continue
            text = path.read_text(encoding="utf-8")
            suspected = any(word in text for word in (*BANNED, "shell", "pickle", "marshal"))
            for node in ast.walk(ast.parse(text if suspected else "")):
                if isinstance(node, ast.Call):
                    called = ast.unparse(node.func)
                    shell = any(one.arg == "shell" for one in node.keywords)
                    named = called in (
                        "eval",
                        "exec",
                        "compile",
                        "os.system",
                        "os.popen",
                        "hashlib.md5",
                        "hashlib.sha1",
                    )
                    if shell or named or called.startswith(("pickle.", "marshal.")):
                        wrong.append(f"{path.relative_to(ROOT)}:{node.lineno}: {called}")
    assert wrong == []


@pytest.mark.parametrize(
    "password",
    [
        "ten letter",
        " spaces at both ends ",
        "걷기 달리기 뛰기 춤추기",
        "".join(f"{trees} tall trees, " for trees in range(99))[:MOST],
        "TRUE\t\x7fé🙂 or ß\v",
    ],
)
def test_a_password_is_what_was_typed(password: str, quick_hashes: None) -> None:
    """Any characters, to the last one, in upper or lower case."""
    kept = hash_password(password, "kim")
    assert opens(password, kept)
    for other in (password.strip() + " ", password.swapcase() + "x", password[:-1], password + "p", password[1:]):
        assert not opens(other, kept)


@one_kind
def test_sessions_are_random(client: TestClient) -> None:
    """32 bytes of the system's randomness each: 256 bits."""
    database = client.app.state.repository.database  # type: ignore[attr-defined]
    with database.write() as tx:
        made = [tx.sessions.open("lab") for _ in range(20)]
    assert len(set(made)) == 20
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{43}", secret) for secret in made)
