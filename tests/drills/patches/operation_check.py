"""Route, description, Python call and command are there."""

from pathlib import Path

from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from mcml_service.storage.database import Database
from tests.builders import bvh, description, served

Path("walk.bvh").write_bytes(bvh(3))
mcml.open("store.db").close()
with served(Database("sqlite:///store.db")) as client:
    assert client.get("/api/v1/longest").status_code == 404
    with mcml.open("store.db") as store:
        store.import_("walk.bvh")
    assert client.get("/api/v1/longest").json()["frames"] == 3
assert "/api/v1/longest" in description()["paths"]
with mcml.open("store.db") as store:
    assert store.operations.find_longest().frames == 3
    printed = CliRunner().invoke(app, ["longest", "--database", "sqlite:///store.db"])
    assert store.documents()[0].id in printed.output, printed.output
