"""What attackers of web services try first: each is tried here, over HTTP."""

from __future__ import annotations

import hmac
import io
import itertools
import json
import logging
import socket
import stat
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from mcml_service.api import authentication
from mcml_service.app import create_app
from mcml_service.operations import all_operations
from mcml_service.operations.operation import Effect
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import MCML, SECRET, bvh, upload

pytestmark = pytest.mark.above_store

API = "/api/v1"
PLAIN, TLS = "http://lab.example", "https://lab.example"
WORDS = "four words in a row"


@pytest.fixture
def kind() -> str:
    """Of database: what is attacked here lies before it."""
    return "sqlite"


def visitor(app: Any, base: str = TLS, address: str = "10.0.0.7", **headers: str) -> TestClient:
    """A browser elsewhere, on a page of the server."""
    return TestClient(app, base_url=base, client=(address, 1), headers={"origin": base, **headers})


@pytest.fixture
def app(database: Database, quick_hashes: None) -> Any:
    return create_app(Settings(trusted_proxies="10.0.0.9"), database, lambda: SECRET)


@pytest.fixture
def kim(app: Any) -> TestClient:
    """The browser of an owner with an account, by TLS."""
    local = TestClient(app, PLAIN, client=("127.0.0.1", 1), headers={"authorization": f"Bearer {SECRET}"})
    assert local.post(f"{API}/accounts", json={"name": "kim", "password": WORDS}).status_code == 201
    client = visitor(app)
    joined = client.post(f"{API}/session", json={"name": "kim", "password": WORDS})
    assert joined.status_code == 201, joined.text
    return client


# -- TLS ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "address", "headers", "strict"),
    [
        (PLAIN, "10.0.0.7", {}, False),
        (TLS, "10.0.0.7", {}, True),
        (PLAIN, "10.0.0.9", {"x-forwarded-proto": "https"}, True),
        (PLAIN, "10.0.0.7", {"x-forwarded-proto": "https"}, False),
        (TLS, "10.0.0.9", {"x-forwarded-proto": "http"}, False),
    ],
)
def test_browsers_stay_with_tls_where_there_is_any(
    app: Any, base: str, address: str, headers: dict[str, str], strict: bool
) -> None:
    client = visitor(app, base, address, **headers)
    for path in ("/healthz", "/login", f"{API}/documents", "/nowhere", "/?a=%00"):
        said = client.get(path).headers.get("strict-transport-security")
        assert said == ("max-age=31536000" if strict else None), path


def test_the_cookie_of_tls_is_of_this_server_alone(kim: TestClient, app: Any) -> None:
    """Neighbours under the same domain, and pages without TLS, can set no cookie of this name."""
    said = kim.post(f"{API}/session", json={"name": "kim", "password": WORDS}).headers["set-cookie"]
    name, _, rest = said.partition("=")
    assert name == "__Host-mcml_session"
    assert {"secure", "httponly", "path=/", "samesite=strict"} <= {part.strip() for part in rest.lower().split(";")}
    assert "domain" not in rest.lower()
    secret = kim.cookies["__Host-mcml_session"]
    assert visitor(app, cookie=f"__Host-mcml_session={secret}").get(f"{API}/account").status_code == 200
    assert visitor(app, cookie=f"mcml_session={secret}").get(f"{API}/account").status_code == 401


# -- sessions ----------------------------------------------------------------------------------------------------------


def test_a_session_ends_where_the_next_begins(kim: TestClient, app: Any) -> None:
    """Whoever had put the first one into the browser has nothing of the second (session fixation)."""
    before = kim.cookies["__Host-mcml_session"]
    assert kim.post(f"{API}/session", json={"name": "kim", "password": "another one"}).status_code == 403
    assert kim.get(f"{API}/account").status_code == 200, "a login that fails ends nothing"
    form = {"name": "kim", "password": WORDS}
    assert kim.post("/login", data=form, follow_redirects=False).status_code == 303
    assert kim.cookies["__Host-mcml_session"] != before
    assert kim.get(f"{API}/account").status_code == 200
    assert visitor(app, cookie=f"__Host-mcml_session={before}").get(f"{API}/account").status_code == 401


def test_a_session_that_was_closed_opens_nothing_and_leaves_nothing(kim: TestClient, app: Any) -> None:
    secret = kim.cookies["__Host-mcml_session"]
    closed = kim.delete(f"{API}/session")
    assert (closed.status_code, closed.headers["clear-site-data"]) == (204, '"cache", "storage"')
    assert "__Host-mcml_session" not in kim.cookies
    assert visitor(app, cookie=f"__Host-mcml_session={secret}").get(f"{API}/account").status_code == 401


@pytest.mark.parametrize(
    "origin", ["https://evil.example", PLAIN, "https://lab.example.evil.example", "https://lab.example:8443", "null"]
)
def test_pages_of_others_write_nothing(kim: TestClient, origin: str) -> None:
    """CSRF: a page without TLS is another page, too, even of the same name."""
    answer = kim.post(f"{API}/documents", files={"file": ("a.bvh", bvh(2))}, headers={"origin": origin})
    assert answer.status_code == 403
    assert kim.get(f"{API}/documents").json()["total"] == 0


def test_nothing_is_changed_by_reading() -> None:
    """No operation that writes has GET, so no picture or link on another page writes."""
    writing = [
        operation for operation in all_operations() if operation.address is not None and operation.method == "GET"
    ]
    assert writing
    assert {operation.effect for operation in writing} <= {Effect.READS, Effect.STREAMS}


# -- guessing ----------------------------------------------------------------------------------------------------------


def test_a_name_is_not_guessed_from_many_addresses(kim: TestClient, app: Any) -> None:
    asked = {"name": "kim", "password": "wrong words in a row"}
    codes = [
        visitor(app, address=f"10.1.0.{number}").post(f"{API}/session", json=asked).status_code for number in range(31)
    ]
    assert codes == [403] * 30 + [429]
    # Whoever is in stays in: an attacker shuts nobody out who has a session or a token.
    assert kim.get(f"{API}/account").status_code == 200


def test_secrets_are_compared_in_the_same_time(
    database: Database, app: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The one that is kept in clear by a comparison of constant time; all others are looked up by their digest."""
    compared: list[tuple[bytes, bytes]] = []

    class Watched:
        @staticmethod
        def compare_digest(one: bytes, other: bytes) -> bool:
            compared.append((one, other))
            return hmac.compare_digest(one, other)

    monkeypatch.setattr(authentication, "hmac", Watched)
    local = TestClient(app, PLAIN, client=("127.0.0.1", 1))
    for given, status in ((SECRET, 200), (SECRET[:-1], 401), (f"{SECRET}x", 401)):
        bearer = {"authorization": f"Bearer {given}"}
        assert local.get(f"{API}/documents", headers=bearer).status_code == status
        assert compared.pop() == (given.encode(), SECRET.encode())
    with database.write() as tx:
        token = tx.tokens.add("lab")
    kept = b"".join(path.read_bytes() for path in tmp_path.glob("store.db*"))
    assert b"lab" in kept
    assert token.encode() not in kept


@pytest.mark.parametrize(
    "then",
    ["//evil.example", "https://evil.example", "/\\evil.example", "\\\\evil.example", "javascript:alert(1)",
     "/\t/evil.example", "/\n/evil.example", " //evil.example", "///evil.example", "evil.example", "/%09/evil.example",
     ""],
)  # fmt: skip
def test_a_login_leads_nowhere_else(kim: TestClient, then: str) -> None:
    form = {"name": "kim", "password": WORDS, "then": then}
    leads = kim.post("/login", data=form, follow_redirects=False).headers["location"]
    assert leads.startswith("/")
    assert not leads.startswith(("//", "/\\"))
    assert not set(leads) & set("\t\r\n\\")
    assert "evil.example" not in leads or leads.startswith("/%")


@pytest.mark.parametrize("path", ["/docs/", "/api/v1/documents/", "/api/v1/tokens/x%2F"])
def test_no_answer_leads_to_where_a_request_says_that_it_came(kim: TestClient, path: str) -> None:
    answer = kim.get(path, headers={"host": "evil.example"}, follow_redirects=False)
    assert answer.status_code in (404, 405)
    assert "evil.example" not in answer.headers.get("location", "")


# -- XML ---------------------------------------------------------------------------------------------------------------


@pytest.fixture
def listener() -> Iterator[tuple[socket.socket, str]]:
    """A server that somebody's document wants to be asked, and its address."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        yield server, f"http://127.0.0.1:{server.getsockname()[1]}/x"


def documents(address: str, file: str) -> dict[str, bytes]:
    """Documents that would have something else read."""
    body = MCML.partition(b'"mcml.dtd">')[2]
    include = b'<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" parse="text" href="%s"/>'
    schema = b'<mcml xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="a %s" version="1.0">'
    made = {}
    for kind, place in (("network", address.encode()), ("file", f"file://{file}".encode())):
        made |= {
            f"entity, {kind}": b'<!DOCTYPE mcml [<!ENTITY x SYSTEM "%s">]>' % place
            + body.replace(b"hand.mcml", b"&x;"),
            f"parameter entity, {kind}": b'<!DOCTYPE mcml [<!ENTITY % x SYSTEM "' + place + b'"> %x;]>' + body,
            f"DTD, {kind}": b'<!DOCTYPE mcml SYSTEM "%s">' % place + body,
            f"XInclude, {kind}": body.replace(b"hand.mcml", include % place),
            f"stylesheet, {kind}": b'<?xml-stylesheet type="text/xsl" href="%s"?>' % place + body,
            f"schema, {kind}": body.replace(b'<mcml version="1.0">', schema % place),
        }
    return made


def test_documents_have_nothing_else_read(
    client: TestClient, tmp_path: Path, listener: tuple[socket.socket, str]
) -> None:
    """Uploaded whole, or as a piece that is put into a document."""
    server, address = listener
    secret = tmp_path / "secret"
    secret.write_text("xyzzy")
    uuid = upload(client, {"hand.mcml": MCML})["documents"][0]["id"]  # type: ignore[index]
    place = f"{API}/documents/{uuid}/elements?xpath=/mcml/header/filename"
    for name, content in documents(address, str(secret)).items():
        answer = client.post(f"{API}/documents", files={"file": ("a.mcml", content)})
        assert answer.status_code in (201, 415, 422), name
        assert (answer.status_code == 201) == name.startswith("stylesheet"), name
        assert "xyzzy" not in answer.text, name
        piece = content.partition(b"<mcml")[0] + b"<filename>&x;</filename>"
        if name.startswith("XInclude"):
            piece = b"<filename>" + content.partition(b"<filename>")[2].partition(b"</filename>")[0] + b"</filename>"
        headers = {"if-match": "*", "content-type": "application/xml"}
        put = client.put(place, content=piece, headers=headers)
        assert put.status_code in (400, 422), (name, put.text)
        assert "xyzzy" not in put.text, name
    with pytest.raises(BlockingIOError):
        server.accept()
    listed = [one["id"] for one in client.get(f"{API}/documents").json()["items"]]
    assert not any("xyzzy" in client.get(f"{API}/documents/{one}/mcml").text for one in listed)


def bombs() -> dict[str, bytes]:
    """Pieces that grow when they are read."""
    laughs = b"".join(b'<!ENTITY %c "%s">' % (98 + n, b"&%c;" % (97 + n) * 10) for n in range(9))
    return {
        "billion laughs": b'<!DOCTYPE filename [<!ENTITY a "ha">' + laughs + b"]><filename>&j;</filename>",
        "quadratic": b'<!DOCTYPE filename [<!ENTITY a "'
        + b"a" * 50_000
        + b'">]><filename>'
        + b"&a;" * 50_000
        + b"</filename>",
        "deep": b"<filename>" * 100_000 + b"</filename>" * 100_000,
        # Each was once looked for among all, for a minute.
        "attributes": b"<filename " + b" ".join(b'a%d="1"' % n for n in range(200_000)) + b">a</filename>",
    }


@pytest.mark.timeout(30)
def test_pieces_do_not_grow(client: TestClient) -> None:
    uuid = upload(client, {"hand.mcml": MCML})["documents"][0]["id"]  # type: ignore[index]
    place = f"{API}/documents/{uuid}/elements?xpath=/mcml/header/filename"
    for name, piece in bombs().items():
        answer = client.put(place, content=piece, headers={"if-match": "*", "content-type": "application/xml"})
        assert answer.status_code in (400, 413, 422), (name, answer.text)
        assert len(answer.content) < 5_000, name


# -- names of files ----------------------------------------------------------------------------------------------------

NAMES = ("../../evil.bvh", "/tmp/evil.bvh", "..\\..\\evil.bvh", "C:\\evil.bvh", "a/../../evil.bvh", "nul.bvh", "..")


def test_zips_leave_their_place_neither_in_nor_out(client: TestClient, tmp_path: Path) -> None:
    """Zip slip: members with other places in their names, and links; what is packed again has names of files alone."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name in NAMES[:-1]:
            archive.writestr(name, bvh(2))
        link = zipfile.ZipInfo("link.bvh")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, "/etc/passwd")
    before = set(tmp_path.parent.rglob("evil*"))
    answer = client.post(f"{API}/documents", files={"file": ("clips.zip", packed.getvalue())})
    assert "root:" not in answer.text
    archive_without = io.BytesIO()
    with zipfile.ZipFile(archive_without, "w") as archive:
        for name in NAMES[:-1]:
            archive.writestr(name, bvh(2))
    stored = client.post(f"{API}/documents", files={"file": ("clips.zip", archive_without.getvalue())}).json()
    assert [one["name"] for one in stored["documents"]] == ["evil"] * 5 + ["nul"]
    assert set(tmp_path.parent.rglob("evil*")) == before
    uuids = [one["id"] for one in client.get(f"{API}/documents").json()["items"]]
    for uuid, name in zip(uuids, itertools.cycle(NAMES), strict=False):
        renamed = client.patch(f"{API}/documents/{uuid}", json={"name": name}, headers={"if-match": "*"})
        assert renamed.status_code == 200, renamed.text
    out = client.post(f"{API}/exports", json={"selection": {"documents": uuids}, "format": "bvh"})
    assert out.status_code == 200, out.text
    with zipfile.ZipFile(io.BytesIO(out.content)) as archive:
        members = [member for member in archive.namelist() if not member.endswith(".json")]
    assert len(members) >= len(uuids)
    for member in members:
        assert not set("/\\:") & set(member), member
        assert member.strip(". ") not in ("", "evil"), member


@pytest.mark.parametrize(
    "path",
    ["/assets/..%2f..%2f..%2fmcml.dtd", "/assets/%2e%2e%2fbuild.py", "/assets/..%5cbuild.py", "/assets//etc/passwd",
     "/docs/assets/..%2f__init__.py", "/assets/.%00./index.html", "/.git/config", "/assets/../../.git/config"],
)  # fmt: skip
def test_addresses_do_not_leave_the_studio(client: TestClient, path: str) -> None:
    assert client.get(path).status_code in (400, 404), path


# -- the log -----------------------------------------------------------------------------------------------------------


def test_secrets_are_not_in_the_log(kim: TestClient, app: Any, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG):
        token = kim.post(f"{API}/tokens", json={"name": "farm", "scope": "read"}).json()["token"]
        invited = kim.post(f"{API}/invitations", json={}).json()
        kim.get(invited["path"])
        kim.post(f"{API}/session", json={"name": "kim", "password": WORDS})
        kim.post(f"{API}/session", json={"token": token})
        visitor(app, authorization=f"Bearer {token}").get(f"{API}/documents")
        visitor(app).get(f"{API}/documents?token={token}")
        cookie = kim.cookies["__Host-mcml_session"]
        kim.get(f"{API}/documents/none")
    ours = [record for record in caplog.records if record.name.startswith(("mcml", "uvicorn"))]
    told = json.dumps([{**vars(record), "said": record.getMessage()} for record in ours], default=str)
    assert f"{API}/documents/none" in told
    for secret in (token, invited["code"], WORDS, cookie):
        assert secret not in told
