"""`make migration NAME=what_changed`: a migration made of the difference between the tables and a fresh store."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from alembic import command
from alembic.config import Config

from mcml_service.resources import migrations_path
from mcml_service.storage.core.schema import metadata
from mcml_service.storage.database import Database
from mcml_service.storage.work import tables as work_tables  # noqa: F401 - they add themselves to the metadata


def make_migration(name: str, folder: Path) -> Path:
    """Write the next migration of a folder of them; the file."""
    versions = folder / "versions"
    before = set(versions.glob("*.py"))
    number = max(int(path.name[:4]) for path in versions.glob("[0-9][0-9][0-9][0-9]_*.py")) + 1
    with tempfile.TemporaryDirectory() as place:
        database = Database(f"sqlite:///{place}/fresh.db")
        database.migrate()
        config = Config()
        config.set_main_option("script_location", str(folder))
        config.attributes["metadata"] = metadata
        with database.dialect.writing() as connection:
            config.attributes["connection"] = connection
            command.revision(config, message=name, autogenerate=True, rev_id=f"{number:04}")
        database.close()
    (made,) = set(versions.glob("*.py")) - before
    return made


if __name__ == "__main__":
    if len(sys.argv) != 2 or not sys.argv[1].isidentifier():
        sys.exit("Say what changed, in words joined by underscores: make migration NAME=what_changed")
    print(make_migration(sys.argv[1], migrations_path()))
