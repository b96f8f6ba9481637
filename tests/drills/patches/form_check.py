"""The command writes frames in the new form."""

from pathlib import Path

from typer.testing import CliRunner

import mcml
from mcml_service.cli import app
from tests.builders import bvh

Path("walk.bvh").write_bytes(bvh(3))
with mcml.open("store.db") as store:
    store.import_("walk.bvh")
done = CliRunner().invoke(app, ["numbers", "walk", "walk.tsv", "--database", "sqlite:///store.db"])
assert done.exit_code == 0, done.output
rows = [line.split("\t") for line in Path("walk.tsv").read_text().splitlines()]
assert rows[0][:3] == ["frame", "id", "time"]
assert len(rows) == 4
