"""Built files of the studio while they are built again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import anyio
import pytest
from fastapi.testclient import TestClient

from mcml_service.api import studio


def test_a_file_that_is_built_again_while_it_is_sent_has_the_length_that_is_told(
    client: TestClient,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    page = tmp_path / "index.html"
    page.write_text("<p>studio</p>")
    monkeypatch.setattr(studio, "STATIC", tmp_path)
    opened = anyio.open_file

    async def built_again(*given: Any, **more: Any) -> Any:
        page.write_text("<p>studio</p>" * 1000)
        return await opened(*given, **more)

    monkeypatch.setattr(anyio, "open_file", built_again)
    answer = client.get("/", headers={"accept-encoding": "identity"})
    assert int(answer.headers["content-length"]) == len(answer.content)
    assert client.get("/favicon.svg").status_code == 404


@pytest.mark.parametrize("path", ["/nowhere", "/clips", "/library/x", "/wp-admin/index.php"])
def test_an_unknown_address_is_a_page_for_browsers(client: TestClient, path: str) -> None:
    browser = {"accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    shown = client.get(path, headers=browser)
    assert (shown.status_code, shown.headers["content-type"].partition(";")[0]) == (404, "text/html")
    assert "default-src 'none'" in shown.headers["content-security-policy"]
    for headers, asked in (({"accept": "application/json"}, path), ({}, path), (browser, f"/api/v1{path}")):
        answer = client.get(asked, headers=headers)
        assert (answer.status_code, answer.json()["status"]) == (404, 404), asked
