"""The analysis has a route, and a command whose result can be read."""

from pathlib import Path

from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from tests.builders import bvh, description

Path("walk.bvh").write_bytes(bvh(3))
assert "/api/v1/analyses/travel" in str(description()["paths"])
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
    (walk,) = store.documents()
    command = ["analyse", "travel", "measure", "--document", walk.id, "--database", "sqlite:///store.db"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    (result,) = store.operations.list_results().items
    part = store.operations.get_result_part(id=result.id, part="ways")
    assert "walk" in str(part), part
