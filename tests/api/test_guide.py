"""The guide: the documentation as pages, served by the service without scripts or files from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path
from urllib.parse import unquote, urljoin, urlsplit

import pytest
from fastapi.testclient import TestClient

from mcml_service.api import guide

ROOT = Path(__file__).parents[2]
BUILT = pytest.mark.skipif(not (guide.GUIDE / "index.html").is_file(), reason="the guide is not built (make web)")


@BUILT
def test_the_address_leads_to_the_first_page(client: TestClient) -> None:
    for address in ("/docs/guide", "/docs/guide/"):
        answer = client.get(address)
        assert answer.status_code == 200
        assert answer.url.path == "/docs/guide/index.html"
    assert "Getting started" in answer.text


@BUILT
def test_every_document_is_a_page_and_loads_from_this_server_alone(client: TestClient) -> None:
    documents = [path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")]
    assert len(documents) > 80
    loaded = set()
    for document in documents:
        address = f"/docs/guide/{document.with_suffix('.html').as_posix()}"
        answer = client.get(address)
        assert answer.status_code == 200, address
        for source in re.findall(r'<(?:script|img|link)\b[^>]*\b(?:src|href)="([^"#]+)', answer.text):
            loaded.add(urljoin(address, unquote(source)))
    for address in sorted(loaded):
        assert not urlsplit(address).netloc, address
        assert client.get(address).status_code == 200, address


@BUILT
def test_pages_may_run_only_the_scripts_that_they_were_built_with(client: TestClient) -> None:
    answer = client.get("/docs/guide/api/index.html")
    policy = answer.headers["content-security-policy"]
    scripts = re.findall(r"<script>(.*?)</script>", answer.text, re.DOTALL)
    assert scripts
    for script in scripts:
        assert base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() in policy
    assert "unsafe" not in policy


@BUILT
@pytest.mark.parametrize("path", ["nothing.html", "../index.html", "%2e%2e/index.html", "..%2f..%2f..%2fREADME.md"])
def test_other_files_are_not_served(client: TestClient, path: str) -> None:
    answer = client.get(f"/docs/guide/{path}")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


def test_a_guide_that_is_not_built_is_told(client: TestClient, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(guide, "GUIDE", tmp_path)
    answer = client.get("/docs/guide/index.html")
    assert answer.status_code == 404
    assert "make docs" in answer.json()["remedy"]
