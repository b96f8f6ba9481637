"""The house: layers, sizes, names, one migration that makes what the tables say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from service.storage.database import Database
from service.storage.schema import metadata

ROOT = Path(__file__).resolve().parents[2]
LINES = 400
ATTICS = {"utils", "helpers", "common", "manager", "misc"}


def sources() -> list[Path]:
    folders = ("service", "schemas", "benchmarks", "tests")
    return [path for folder in folders for path in (ROOT / folder).rglob("*.py") if "static" not in path.parts]


def test_layers() -> None:
    command = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run([command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_files_stay_readable() -> None:
    long = {str(path.relative_to(ROOT)): lines for path in sources() if (lines := path.read_text().count("\n")) > LINES}
    assert not long, "split these at their second reason to change"


def test_no_attics() -> None:
    assert not [path for path in sources() if path.stem in ATTICS]


def test_migrations_make_what_the_tables_say(database: Database) -> None:
    with database.dialect.reading() as connection:
        differences = compare_metadata(MigrationContext.configure(connection), metadata)
    assert differences == []


def test_only_storage_and_the_query_plan_speak_sql() -> None:
    allowed = ("service/storage/", "service/xpath/plan.py", "service/actions/keep_store.py")
    for path in (ROOT / "service").rglob("*.py"):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith(allowed):
            assert "import sqlalchemy" not in path.read_text(), name
            assert "from sqlalchemy" not in path.read_text(), name
