"""A client that openapi-python-client makes of the API's description uploads, asks and downloads; none is left out."""

from __future__ import annotations

import importlib
import io
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mcml_service.app import create_app
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.api.test_authentication import listening
from tests.builders import SECRET, bvh, description, one_kind


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a package `lab_client`."""
    folder = tmp_path_factory.mktemp("generated")
    (folder / "openapi.json").write_text(json.dumps(description()))
    (folder / "config.yml").write_text("post_hooks: []\n")
    command = [Path(sys.executable).with_name("openapi-python-client"), "generate", "--path", "openapi.json"]
    command += ["--meta", "none", "--output-path", "lab_client", "--config", "config.yml"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=120)
    sys.path.insert(0, str(folder))
    yield folder / "lab_client"
    sys.path.remove(str(folder))


@pytest.mark.slow
def test_no_operation_is_left_out(generated: Path) -> None:
    names = {item["operationId"] for path in description()["paths"].values() for item in path.values()}
    modules = {path.stem for path in (generated / "api").rglob("*.py") if path.stem != "__init__"}
    assert modules == names


@pytest.mark.slow
@one_kind
def test_a_script_uploads_asks_and_downloads(generated: Path, database: Database) -> None:
    def module(name: str) -> Any:
        return importlib.import_module(f"lab_client.{name}")

    app = create_app(Settings(host="127.0.0.1"), database, lambda: SECRET)
    with listening(app) as port:
        client = module("client").AuthenticatedClient(f"http://127.0.0.1:{port}", token=SECRET)
        file = module("types").File(payload=io.BytesIO(bvh(30)), file_name="걸음.bvh")
        body = module("models").BodyUploadDocuments(file=[file], project="gait", label=["walk:1-20", "turn"])
        made = module("api.uploads.upload_documents").sync(client=client, body=body)
        uuid = made.documents[0].id
        assert made.documents[0].name == "걸음"

        listed = module("api.documents.list_documents").sync(client=client, project="gait", motion_name="walk")
        assert [(item.id, item.frames) for item in listed.items] == [(uuid, 30)]

        asked = module("api.queries.get_query").sync(
            client=client, q="//frame[motion_name='walk']", as_=module("models").GetQueryAs.RUNS
        )
        assert [(run.first, run.last) for run in asked.items] == [(1, 20)]

        file = module("api.exports.export_document").sync_detailed(uuid, client=client, format_="bvh")
        assert (file.status_code, file.content) == (200, bvh(30))

        zipped = module("api.exports.export_documents").sync_detailed(
            client=client,
            body=module("models").ExportRequest(selection=module("models").Selection(project="gait"), format_="htr"),
        )
        assert zipped.content.startswith(b"PK")

        refused = module("api.documents.get_document").sync_detailed(
            "01a1fd5b-63fa-7af5-9027-3f8ccdfe4736", client=client
        )
        assert refused.status_code == 404
